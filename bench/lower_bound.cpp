#include "bench/lower_bound.hpp"

#include <ClpSimplex.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace baton::bench {
namespace {

constexpr int kIntervals = 100;  ///< at least
constexpr double kExact = 1e-6;  ///< of the boundary rows [m]
constexpr int kMostCourses = 2000;

/// The linear program for one duration, given the polygon of each interval.
class Program {
 public:
  Program(const ComProblem& problem, double period) : problem_(&problem), period_(period) {
    const double height = problem.p0.z() - problem.plane;
    if (std::abs(problem.goal.z() - problem.p0.z()) > 1e-9 || std::abs(problem.dp0.z()) > 1e-9)
      throw std::invalid_argument("lower bound: the COM's height changes");
    omega_ = std::sqrt(kGravity / height);
    for (const SupportPhase& phase : problem.phases)
      inside_.push_back(phase.support.inset(problem.margin));
    std::vector<Vec2> all;
    for (const ConvexPolygon& polygon : inside_)
      all.insert(all.end(), polygon.vertices().begin(), polygon.vertices().end());
    either_ = ConvexPolygon::hull(all);
  }

  [[nodiscard]] const ConvexPolygon& inside(std::size_t phase) const { return inside_[phase]; }
  /// Hull of all polygons, for intervals whose phase is uncertain.
  [[nodiscard]] const ConvexPolygon& either() const { return either_; }

  /// Column generation. A column is the effect of one ZMP trajectory, at a vertex in each interval, on the two boundary
  /// rows of x and y; a convex combination must satisfy them. The dual prices yield the best trajectory to add; if even
  /// that one does not help, the program is infeasible.
  /// @param polygon_at of each tick
  template <typename PolygonAt>
  [[nodiscard]] bool feasible(int ticks, const PolygonAt& polygon_at) const {
    const int parts = (kIntervals + ticks - 1) / ticks;  // intervals per tick
    const int n = parts * ticks;
    const double h = period_ / parts;
    const double T = ticks * period_;
    const double E = std::exp(-omega_ * h);
    // With ξ = p + ṗ/ω and η = p − ṗ/ω:  Σ c_k zmp_k = ξ₀ − e^{−ωT} goal,  Σ d_k zmp_k = goal − e^{−ωT} η₀.
    const double decay = std::exp(-omega_ * T);
    std::vector<double> c, d;
    for (int k = 0; k < n; ++k) {
      c.push_back(std::exp(-omega_ * k * h) * (1.0 - E));
      d.push_back(std::exp(-omega_ * (T - (k + 1) * h)) * (1.0 - E));
    }
    const Vec2 p0 = problem_->p0.head<2>();
    const Vec2 speed = problem_->dp0.head<2>() / omega_;
    const Vec2 goal = problem_->goal.head<2>();
    Eigen::Vector4d wanted;
    wanted << p0 + speed - decay * goal, goal - decay * (p0 - speed);

    // Rows: the four boundary rows, and that weights sum to 1. Columns: slacks, at a cost, and trajectories.
    constexpr std::array<int, 5> kRows{0, 1, 2, 3, 4};
    constexpr double kFree = 1e30;
    ClpSimplex lp;
    lp.setLogLevel(0);
    lp.setDualTolerance(1e-9);
    lp.resize(5, 0);
    for (int row = 0; row < 4; ++row) {
      lp.setRowBounds(row, wanted[row], wanted[row]);
      for (const double sign : {1.0, -1.0})
        lp.addColumn(1, &row, &sign, 0.0, kFree, 1.0);
    }
    lp.setRowBounds(4, 1.0, 1.0);
    Eigen::Vector4d price = wanted;
    for (int tries = 0; tries < kMostCourses; ++tries) {
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (int k = 0; k < n; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const Vec2 along = c[i] * price.head<2>() + d[i] * price.tail<2>();
        const Vec2* best = nullptr;
        double most = 0.0;
        for (const Vec2& vertex : polygon_at(k / parts).vertices()) {
          const double value = along.dot(vertex);
          if (best == nullptr || value > most) {
            best = &vertex;
            most = value;
          }
        }
        sum.head<2>() += c[i] * *best;
        sum.tail<2>() += d[i] * *best;
      }
      if (price.dot(wanted - sum) > kExact * price.cwiseAbs().maxCoeff()) return false;
      const std::array<double, 5> column{sum[0], sum[1], sum[2], sum[3], 1.0};
      lp.addColumn(5, kRows.data(), column.data(), 0.0, kFree, 0.0);
      lp.primal();
      if (lp.objectiveValue() < kExact) return true;
      price = Eigen::Map<const Eigen::Vector4d>(lp.dualRowSolution());
    }
    throw std::runtime_error("lower bound: the linear program does not end");
  }

 private:
  const ComProblem* problem_;
  double period_;
  double omega_ = 1.0;
  std::vector<ConvexPolygon> inside_;
  ConvexPolygon either_;
};

}  // namespace

std::optional<int> least_ticks(const ComProblem& problem, std::optional<std::size_t> swing, int least_swing,
                               int longest, double period, int guess) {
  const Program program(problem, period);
  const auto phases = static_cast<int>(problem.phases.size());
  for (int i = 0; i < phases; ++i) {
    if (program.inside(static_cast<std::size_t>(i)).empty()) return std::nullopt;
    if (!swing) continue;
    for (const Vec2& vertex : program.inside(*swing).vertices()) {
      if (program.inside(static_cast<std::size_t>(i)).margin(vertex) < -1e-6)
        throw std::invalid_argument("lower bound: the single support is not in the double ones");
    }
  }
  const int before = swing ? static_cast<int>(*swing) : 0;  // phases before the swing: 0 or 1
  const int after = swing ? phases - 1 - before : 0;
  const auto begins_between = [&](const auto& self, int ticks, int lo, int hi) -> bool {
    // The swing starts at a tick in lo … hi. Certain are the first phase until lo, the swing from hi to lo + swing
    // time, and the last phase from hi + swing time.
    const auto polygon = [&](int k) -> const ConvexPolygon& {
      if (!swing) return program.inside(0);
      if (k >= hi && k < lo + least_swing) return program.inside(*swing);
      const bool first = k < hi;
      const bool last = k >= lo + least_swing;
      if (first && last) return program.either();
      return program.inside(first ? 0 : static_cast<std::size_t>(phases - 1));
    };
    if (!program.feasible(ticks, polygon)) return false;
    if (lo == hi) return true;
    const int middle = (lo + hi) / 2;
    return self(self, ticks, lo, middle) || self(self, ticks, middle + 1, hi);
  };
  const int least = swing ? before + least_swing + after : 1;
  const auto feasible = [&](int ticks) {
    if (!swing) return begins_between(begins_between, ticks, 0, 0);
    if (before == 0) return begins_between(begins_between, ticks, 0, 0);
    if (after == 0) return begins_between(begins_between, ticks, ticks - least_swing, ticks - least_swing);
    return begins_between(begins_between, ticks, 1, ticks - least_swing - 1);
  };
  // Bracket around the guess, then bisect.
  int fails = least - 1;
  int works = longest + 1;
  int ticks = std::clamp(guess, least, longest);
  int step = 4;
  if (feasible(ticks)) {
    for (works = ticks; works > fails + 1; works = ticks, step *= 2) {
      ticks = std::max(works - step, least);
      if (!feasible(ticks)) {
        fails = ticks;
        break;
      }
    }
  } else {
    for (fails = ticks; fails < works - 1; fails = ticks, step *= 2) {
      ticks = std::min(fails + step, longest);
      if (feasible(ticks)) {
        works = ticks;
        break;
      }
    }
  }
  while (works - fails > 1) {
    const int middle = (works + fails) / 2;
    (feasible(middle) ? works : fails) = middle;
  }
  return works > longest ? std::nullopt : std::optional(works);
}

}  // namespace baton::bench
