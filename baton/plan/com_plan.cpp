#include "baton/plan/com_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace baton {

std::vector<int> phase_borders(const std::vector<SupportPhase>& phases, int ticks) {
  std::vector<int> borders{0};
  double sum = 0.0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    sum += phases[i].share;
    const int left = static_cast<int>(phases.size() - 1 - i);  // phases that still need a tick
    const int border = static_cast<int>(std::lround(sum * ticks));
    borders.push_back(std::max(std::min(border, ticks - left), borders.back() + 1));
  }
  borders.back() = ticks;
  return borders;
}

ComPath com_path(const ComProblem& problem, int ticks, double period) {
  const std::vector<int> borders = phase_borders(problem.phases, ticks);
  std::vector<VrpKnot> knots = problem.knots;
  for (VrpKnot& knot : knots) {
    double share = 0.0;
    double time = knot.t * ticks;
    for (std::size_t i = 0; i < problem.phases.size(); ++i) {
      share += problem.phases[i].share;
      if (std::abs(share - knot.t) < 1e-9) time = borders[i + 1];
    }
    knot.t = time * period;
  }
  return solve_com_path(problem.omega, knots, problem.p0, problem.dp0, problem.goal);
}

ZmpMargin zmp_margin(const ComProblem& problem, const ComPath& path, double period) {
  const int ticks = static_cast<int>(std::lround(path.duration() / period));
  const std::vector<int> borders = phase_borders(problem.phases, ticks);
  ZmpMargin least{std::numeric_limits<double>::infinity(), 0.0};
  const auto check = [&](double t, const ConvexPolygon& support) {
    const ComState com = path.at(t);
    double margin = support.margin(zmp_of_vrp(com.p, com.v, problem.plane, problem.omega));
    if (std::isnan(margin)) margin = -std::numeric_limits<double>::infinity();
    if (margin < least.margin) least = {margin, t};
  };
  for (std::size_t i = 0; i < problem.phases.size(); ++i) {
    const double from = borders[i] * period;
    const double to = borders[i + 1] * period;
    const int steps = std::max(1, static_cast<int>(std::ceil((to - from) / 0.02)));
    for (int k = 0; k <= steps; ++k)
      check(from + (to - from) * k / steps, problem.phases[i].support);
    for (const double t : path.times()) {
      if (t > from && t < to) check(t, problem.phases[i].support);
    }
  }
  return least;
}

ComPlan correct_duration(const ComProblem& problem, double first, double step, double last, double period) {
  ComPlan plan;
  for (double T = first; T <= last + 1e-9; T += step) {
    ++plan.tried;
    plan.ticks = static_cast<int>(std::lround(T / period));
    plan.path = com_path(problem, plan.ticks, period);
    plan.zmp = zmp_margin(problem, plan.path, period);
    plan.feasible = plan.zmp.margin >= problem.margin;
    if (plan.feasible) break;
  }
  return plan;
}

}  // namespace baton
