#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/reproduce.hpp"
#include "baton/plan/com_plan.hpp"
#include "baton/record/output_file.hpp"
#include "baton/record/plot.hpp"

namespace baton::app {
namespace {

// The setting of docs/theory.md §7: mighty, lateral axis only, point mass, equal weights.
constexpr double kComHeight = 0.26;       ///< [m]
constexpr double kFoot = 0.042;           ///< lateral distance of each foot from the middle at the start [m]
constexpr double kSoleHalfWidth = 0.036;  ///< [m]
constexpr double kSoleHalfLength = 0.05;  ///< [m]
constexpr double kStride = 0.03;          ///< of the right foot, to the right, twice [m]
constexpr std::array<double, 3> kShares{0.20, 0.36, 0.44};
constexpr double kFirst = 0.5, kStep = 0.1, kLast = 3.0, kPeriod = 0.005;  ///< durations and tick period [s]
const double kOmega = std::sqrt(9.81 / kComHeight);                        ///< [rad/s]

/// One step of the right foot.
struct Step {
  double left = 0.0, right = 0.0,
         landing = 0.0;  ///< y of the left foot, and of the right foot before and after [m]

  [[nodiscard]] double start() const { return 0.5 * (left + right); }
  [[nodiscard]] double goal() const { return 0.5 * (left + landing); }
  /// y of the stance soles in phase `i`.
  [[nodiscard]] std::vector<double> standing(std::size_t i) const {
    if (i == 1) return {left};
    return {left, i == 0 ? right : landing};
  }
};

ComProblem problem_of(const Step& step) {
  ComProblem problem;
  problem.omega = kOmega;
  // At this height the ZMP is the VRP's projection onto the ground.
  const auto at = [](double y) { return Vec3(0, y, kGravity / (kOmega * kOmega)); };
  problem.p0 = at(step.start());
  problem.goal = at(step.goal());
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    std::vector<Vec2> soles;
    for (const double y : step.standing(i)) {
      for (const double x : {-kSoleHalfLength, kSoleHalfLength}) {
        for (const double side : {-kSoleHalfWidth, kSoleHalfWidth})
          soles.emplace_back(x, y + side);
      }
    }
    problem.phases.push_back({kShares[i], ConvexPolygon::hull(soles)});
  }
  problem.knots = {
      {0.0, problem.p0, 1.0}, {1.0, at(step.left), 1.0}, {2.0, at(step.left), 1.0}, {3.0, problem.goal, 1.0}};
  return problem;
}

/// Checks a plan without the planner's closed forms and polygons: integrates p̈ = ω²(p − v) from the knots
/// (Runge-Kutta, 1 ms) and compares the ZMP with the soles' edges at each step.
struct Check {
  bool at_rest = false;   ///< ends at rest at the goal
  double outside = 0.0;   ///< largest excursion of the ZMP out of the support [m]
  std::vector<Vec2> com;  ///< (t, y)
  std::vector<Vec2> zmp;
};

Check integrate(const Step& step, const ComPath& path) {
  constexpr double h = 1e-3;
  const std::vector<double>& times = path.times();
  const auto v = [&](double t) {
    std::size_t k = 0;
    while (k + 2 < times.size() && t > times[k + 1])
      ++k;
    const double s = (t - times[k]) / (times[k + 1] - times[k]);
    return (1.0 - s) * path.knots()[k].y() + s * path.knots()[k + 1].y();
  };
  const auto slope = [&](double t, const Vec2& x) { return Vec2(x[1], kOmega * kOmega * (x[0] - v(t))); };
  Check check;
  Vec2 x(step.start(), 0.0);
  const int steps = static_cast<int>(std::lround(path.duration() / h));
  for (int k = 0;; ++k) {
    const double t = k * h;
    const double zmp = v(t);
    check.com.emplace_back(t, x[0]);
    check.zmp.emplace_back(t, zmp);
    for (std::size_t i = 0; i < kShares.size(); ++i) {  // at a phase boundary both supports count
      if (t < times[i] - 1e-9 || t > times[i + 1] + 1e-9) continue;
      const std::vector<double> y = step.standing(i);
      check.outside = std::max({check.outside, *std::min_element(y.begin(), y.end()) - kSoleHalfWidth - zmp,
                                zmp - *std::max_element(y.begin(), y.end()) - kSoleHalfWidth});
    }
    if (k == steps) break;
    const Vec2 a = slope(t, x);
    const Vec2 b = slope(t + h / 2, x + h / 2 * a);
    const Vec2 c = slope(t + h / 2, x + h / 2 * b);
    const Vec2 d = slope(t + h, x + h * c);
    x += h / 6 * (a + 2 * b + 2 * c + d);
  }
  check.at_rest = std::abs(x[0] - step.goal()) < 1e-5 && std::abs(x[1]) < 1e-4;
  return check;
}

nlohmann::json knots_of(const ComPath& path) {
  nlohmann::json knots = nlohmann::json::array();
  for (const Vec3& knot : path.knots())
    knots.push_back(knot.y());
  return knots;
}

/// Adds a step that starts at `t0` [s] to the plot.
void show(Panel& panel, const Step& step, const ComPath& path, double t0, Stroke stroke) {
  const Check check = integrate(step, path);
  const std::vector<double>& times = path.times();
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    const std::vector<double> feet = step.standing(i);
    const auto add = [&](const char* name, double low, double high, const char* colour) {
      panel.areas.push_back(
          band(name, {t0 + times[i], low - kSoleHalfWidth}, {t0 + times[i + 1], high + kSoleHalfWidth}, colour, 1.0));
    };
    add("support polygon", *std::min_element(feet.begin(), feet.end()), step.left, "#eeeeee");
    add("left sole", step.left, step.left, "#cfe5f3");
    if (feet.size() > 1) add("right sole", feet[1], feet[1], "#f6e0b5");
  }
  const bool first = panel.series.empty();
  const auto moved = [t0](std::vector<Vec2> points) {
    for (Vec2& point : points)
      point.x() += t0;
    return points;
  };
  std::vector<Vec2> knots;
  for (std::size_t k = 0; k < times.size(); ++k)
    knots.emplace_back(t0 + times[k], path.knots()[k].y());
  panel.series.push_back({first ? "COM" : "", moved(check.com), stroke, palette::kBlue, 2.0});
  panel.series.push_back({first ? "ZMP" : "", moved(check.zmp), stroke, palette::kVermilion, 2.0});
  panel.series.push_back({"", knots, Stroke::points, palette::kVermilion, 3.0});
}

}  // namespace

int reproduce_fig8(const std::filesystem::path& out) {
  const std::array<Step, 2> steps{Step{kFoot, -kFoot, -kFoot - kStride},
                                  Step{kFoot, -kFoot - kStride, -kFoot - 2 * kStride}};
  std::array<ComPlan, 2> plans;
  nlohmann::json segments = nlohmann::json::array();
  bool verified = true;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    plans[i] = correct_duration(problem_of(steps[i]), kFirst, kStep, kLast, kPeriod);
    const Check check = integrate(steps[i], plans[i].path);
    const bool passed = plans[i].feasible && check.at_rest && check.outside == 0.0;
    verified = verified && passed;
    segments.push_back({{"T", plans[i].timing.duration()}, {"knots_y", knots_of(plans[i].path)}, {"verified", passed}});
    spdlog::info("step {}: T = {:.1f} s after {} tries", i + 1, plans[i].timing.duration(), plans[i].tried);
  }
  const ComProblem widened = problem_of(steps[1]);
  const Timing first = timing_by_shares(widened.phases, static_cast<int>(std::lround(kFirst / kPeriod)), kPeriod);
  const ComPath hasty = com_path(widened, first);
  const nlohmann::json summary = {
      {"segments", segments},
      {"uncorrected",
       {{"T", kFirst}, {"knots_y", knots_of(hasty)}, {"zmp_outside_m", integrate(steps[1], hasty).outside}}}};

  const double second = plans[0].path.duration();
  const double end = second + plans[1].path.duration();
  std::array<Panel, 2> panels;
  panels[0].title = fmt::format("Second step not corrected, T = {:.1f} s: the ZMP leaves the left sole", kFirst);
  show(panels[0], steps[0], plans[0].path, 0.0, Stroke::dashed);
  show(panels[0], steps[1], hasty, second, Stroke::dashed);
  panels[1].title = fmt::format("Duration corrected, T = {:.1f} s: the ZMP stays inside", plans[1].path.duration());
  show(panels[1], steps[0], plans[0].path, 0.0, Stroke::solid);
  show(panels[1], steps[1], plans[1].path, second, Stroke::solid);
  for (Panel& panel : panels) {
    panel.x_label = "time [s]";
    panel.y_label = "lateral position [m], left +";
    panel.x_range = Range{-0.02, end + 0.02};
    panel.height = 240.0;
  }
  save_plot(out / "fig8.svg", panels);

  write_whole(out / "fig8.json", "--out", summary.dump(2) + '\n');
  return verified ? 0 : 1;
}

}  // namespace baton::app
