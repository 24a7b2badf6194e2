#include "baton/plan/shortest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace baton {
namespace {

constexpr std::size_t kMostKnots = 16;

/// How much of its supports a timing needs, seen from one side at a time: along a horizontal direction each knot of the
/// ZMP has an interval, and the two boundary rows bound the ends of what the knots can do together (a zonotope in the
/// plane). The load is the factor by which all intervals, about their middles, would have to grow: beyond 1 no knots
/// will do. Exact for a COM at constant height, but for x and y bounding each other.
class Load {
 public:
  explicit Load(const ComProblem& problem) : problem_(&problem) {
    if (problem.knots.size() > kMostKnots) throw std::invalid_argument("shortest_timing: too many VRP knots");
    const double height = problem.p0.z() - problem.plane;
    omega_ = std::sqrt(kGravity / std::max(height, 1e-3));
    places_.resize(problem.knots.size());
    for (std::size_t k = 0; k < places_.size(); ++k)
      places_[k] = problem.knots[k].t;
    for (const SupportPhase& phase : problem.phases) {
      const std::vector<Vec2>& corners = phase.support.vertices();
      for (std::size_t c = 0; c < corners.size(); ++c)
        add((corners[(c + 1) % corners.size()] - corners[c]).normalized());
    }
  }

  /// The load; where it exceeds `enough`, no less than that.
  [[nodiscard]] double of(const Timing& timing, double enough) {
    const std::size_t n = places_.size();
    const double T = timing.duration();
    std::array<double, kMostKnots> E{}, F{};
    std::array<double, kMostKnots> c{}, d{};
    double before = 0.0;
    for (std::size_t k = 0; k + 1 < n; ++k) {
      const double now = timing.at(places_[k + 1]);
      const double a = omega_ * (now - before);
      E[k] = std::exp(-a);
      F[k] = (1.0 - E[k]) / a;
      before = now;
    }
    double start = 1.0;
    for (std::size_t k = 0; k + 1 < n; ++k) {
      c[k] += start * (1.0 - F[k]);
      c[k + 1] += start * (F[k] - E[k]);
      start *= E[k];
    }
    double end = 1.0;
    for (std::size_t k = n - 1; k > 0; --k) {
      d[k - 1] += end * (F[k - 1] - E[k - 1]);
      d[k] += end * (1.0 - F[k - 1]);
      end *= E[k - 1];
    }
    const double decay = std::exp(-omega_ * T);
    double worst = 0.0;
    for (std::size_t i = 0; i < sides_.size() && worst <= enough; ++i) {
      const Side& side = sides_[i];
      double first = side.start + side.speed - decay * side.goal;
      double second = side.goal - decay * (side.start - side.speed);
      for (std::size_t k = 0; k < n; ++k) {
        first -= c[k] * side.middle[k];
        second -= d[k] * side.middle[k];
      }
      for (std::size_t j = 0; j < n; ++j) {  // across the edge of the zonotope that knot j makes
        double reach = 0.0;
        for (std::size_t k = 0; k < n; ++k)
          reach += std::abs(c[j] * d[k] - d[j] * c[k]) * side.half[k];
        worst = std::max(worst, std::abs(c[j] * second - d[j] * first) / reach);
      }
      if (worst > enough) std::swap(sides_[0], sides_[i]);  // to be looked at first next time
    }
    return worst;
  }

 private:
  struct Side {
    Vec2 direction;
    double start, speed, goal;
    std::array<double, kMostKnots> middle, half;
  };

  void add(const Vec2& direction) {
    constexpr double kSame = 0.9998;  // cosine, 1°
    for (const Side& side : sides_) {
      if (std::abs(side.direction.dot(direction)) > kSame) return;
    }
    Side side{direction,
              direction.dot(problem_->p0.head<2>()),
              direction.dot(problem_->dp0.head<2>()) / omega_,
              direction.dot(problem_->goal.head<2>()),
              {},
              {}};
    for (std::size_t k = 0; k < places_.size(); ++k) {
      double lo = -1e9;
      double hi = 1e9;
      for (std::size_t i = 0; i < problem_->phases.size(); ++i) {
        const auto begin = static_cast<double>(i);
        if (places_[k] < begin - 1e-9 || places_[k] > begin + 1.0 + 1e-9) continue;
        double least = 1e9;
        double most = -1e9;
        for (const Vec2& vertex : problem_->phases[i].support.vertices()) {
          least = std::min(least, direction.dot(vertex));
          most = std::max(most, direction.dot(vertex));
        }
        lo = std::max(lo, least + problem_->margin);
        hi = std::min(hi, most - problem_->margin);
      }
      side.middle[k] = 0.5 * (lo + hi);
      side.half[k] = std::max(0.5 * (hi - lo), 1e-6);
    }
    sides_.push_back(side);
  }

  const ComProblem* problem_;
  double omega_ = 1.0;
  std::vector<double> places_;
  std::vector<Side> sides_;
};

/// Durations and divisions of one problem.
class Search {
 public:
  Search(BoundedCom& com, const ComProblem& problem, std::optional<std::size_t> swing, int least_swing, double period)
      : com_(&com), problem_(&problem), load_(problem), least_swing_(swing ? least_swing : 0) {
    timing_.period = period;
    const auto phases = static_cast<int>(problem.phases.size());
    if (!swing || phases == 1) {
      kind_ = Kind::one;
    } else if (phases == 2) {
      kind_ = *swing == 0 ? Kind::lower : Kind::lift;
    } else {
      kind_ = Kind::step;
      share_ = problem.phases[0].share / (problem.phases[0].share + problem.phases[2].share);
    }
    timing_.border.resize(problem.phases.size() + 1);
    least_ = std::max(least_swing_ + phases - (swing ? 1 : 0), phases);
  }

  std::optional<Shortest> run(int longest) {
    // The least duration that the load allows.
    int fails = least_ - 1;
    int works = std::min(least_, longest);
    while (works < longest && divide(works, 1.0) > 1.0) {
      fails = works;
      works = std::min(longest, works + works / kGrowth + 1);
    }
    while (works - fails > 1) {
      const int middle = (works + fails) / 2;
      (divide(middle, 1.0) > 1.0 ? fails : works) = middle;
    }
    // From there on by the quadratic program.
    std::optional<Shortest> best;
    const auto solves = [&](int ticks) {
      divide(ticks, 0.0);
      std::optional<ComPath> path = com_->path(*problem_, timing_);
      if (path) best = Shortest{timing_, *std::move(path)};
      return path.has_value();
    };
    int ticks = works;
    if (solves(ticks)) {
      while (ticks > least_ && solves(ticks - 1))
        --ticks;
      return best;
    }
    fails = ticks;
    for (int step = 1; !best && fails < longest; step *= 2) {
      ticks = std::min(longest, fails + step);
      if (!solves(ticks)) fails = ticks;
    }
    if (!best) return best;
    while (ticks - fails > 1) {
      const int middle = (ticks + fails) / 2;
      (solves(middle) ? ticks : fails) = middle;
    }
    return best;
  }

 private:
  enum class Kind { one, lift, lower, step };
  static constexpr int kGrowth = 4;  ///< a duration that fails grows by this part of it

  void set(int ticks, int before) {
    std::vector<int>& border = timing_.border;
    border.front() = 0;
    border.back() = ticks;
    if (kind_ == Kind::one) return;
    border[1] = kind_ == Kind::lower ? least_swing_ : before;
    if (kind_ == Kind::step) border[2] = before + least_swing_;
  }

  /// Divides a duration so that the load is least, or no more than `enough`; returns the load.
  double divide(int ticks, double enough) {
    const int most = ticks - least_swing_ - 1;
    if (kind_ != Kind::step) {
      set(ticks, ticks - least_swing_);
      return enough > 0.0 ? load_.of(timing_, enough) : 0.0;
    }
    int before = std::clamp(static_cast<int>(std::lround(share_ * (most + 1))), 1, most);
    const auto load_with = [&](int at, double worth) {
      set(ticks, at);
      return load_.of(timing_, worth);
    };
    double least = load_with(before, 1e9);
    for (int step = std::max(1, most / 5); step > 0 && least > enough;) {
      int next = 0;
      for (const int other : {before + step, before - step}) {
        if (next != 0 || other < 1 || other > most) continue;
        const double load = load_with(other, least);
        if (load < least) {
          least = load;
          next = other;
        }
      }
      if (next == 0) {
        step /= 2;
      } else {
        before = next;
      }
    }
    set(ticks, before);
    share_ = static_cast<double>(before) / (most + 1);
    return least;
  }

  BoundedCom* com_;
  const ComProblem* problem_;
  Load load_;
  Timing timing_;
  Kind kind_ = Kind::one;
  int least_swing_ = 0;
  int least_ = 1;
  double share_ = 0.5;  ///< of the double supports, before the swing
};

}  // namespace

std::optional<Shortest> shortest_timing(BoundedCom& com, const ComProblem& problem, std::optional<std::size_t> swing,
                                        int least_swing, int longest, double period) {
  Search search(com, problem, swing, least_swing, period);
  return search.run(longest);
}

}  // namespace baton
