#include "baton/plan/com_plan.hpp"

#include <algorithm>
#include <cmath>
#include <eiquadprog/eiquadprog-fast.hpp>
#include <limits>

namespace baton {
namespace {

/// Desired knots at the times given by a timing.
std::vector<VrpKnot> timed(const ComProblem& problem, const Timing& timing) {
  std::vector<VrpKnot> knots = problem.knots;
  for (VrpKnot& knot : knots)
    knot.t = timing.at(knot.t);
  return knots;
}

std::vector<double> times_of(const std::vector<VrpKnot>& knots) {
  std::vector<double> times;
  for (const VrpKnot& knot : knots)
    times.push_back(knot.t);
  return times;
}

}  // namespace

double Timing::at(double place) const {
  const std::size_t last = border.size() - 2;
  const std::size_t phase = std::min(static_cast<std::size_t>(std::max(0.0, place + 1e-9)), last);
  const double within = place - static_cast<double>(phase);
  return period * (border[phase] + within * (border[phase + 1] - border[phase]));
}

Timing timing_by_shares(const std::vector<SupportPhase>& phases, int ticks, double period) {
  Timing timing{period, {0}};
  double sum = 0.0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    sum += phases[i].share;
    const int left = static_cast<int>(phases.size() - 1 - i);  // later phases, each needing a tick
    const int border = static_cast<int>(std::lround(sum * ticks));
    timing.border.push_back(std::max(std::min(border, ticks - left), timing.border.back() + 1));
  }
  timing.border.back() = ticks;
  return timing;
}

ComPath com_path(const ComProblem& problem, const Timing& timing) {
  return solve_com_path(problem.omega, timed(problem, timing), problem.p0, problem.dp0, problem.goal);
}

ZmpMargin zmp_margin(const ComProblem& problem, const ComPath& path, const Timing& timing) {
  ZmpMargin least{std::numeric_limits<double>::infinity(), 0.0};
  const auto check = [&](double t, const ConvexPolygon& support) {
    const ComState com = path.at(t);
    double margin = support.margin(zmp_of_vrp(com.p, com.v, problem.plane, problem.omega));
    if (std::isnan(margin)) margin = -std::numeric_limits<double>::infinity();
    if (margin < least.margin) least = {margin, t};
  };
  if (!problem.at_start.vertices().empty()) check(0.0, problem.at_start);
  for (std::size_t i = 0; i < problem.phases.size(); ++i) {
    const double from = timing.border[i] * timing.period;
    const double to = timing.border[i + 1] * timing.period;
    const int steps = std::max(1, static_cast<int>(std::ceil((to - from) / 0.02)));
    for (int k = 0; k <= steps; ++k)
      check(from + (to - from) * k / steps, problem.phases[i].support);
    for (const double t : path.times()) {
      if (t > from && t < to) check(t, problem.phases[i].support);
    }
  }
  return least;
}

struct BoundedCom::Workspace {
  eiquadprog::solvers::EiquadprogFast qp;
  MatX H, CE, CI;
  VecX g, ce, ci, x;
};

BoundedCom::BoundedCom() : w_(std::make_unique<Workspace>()) {}
BoundedCom::~BoundedCom() = default;

std::optional<ComPath> BoundedCom::path(const ComProblem& problem, const Timing& timing, const VrpOffset& offset) {
  const std::vector<VrpKnot> knots = timed(problem, timing);
  const KnotResponse r = knot_response(problem.omega, knots, problem.p0, problem.dp0, problem.goal, offset);
  std::vector<Vec3> v = nearest_knots(knots, r);
  const auto build = [&] { return ComPath(problem.omega, times_of(knots), v, problem.p0, problem.dp0, offset); };
  const auto fits = [&](const ComPath& path) { return zmp_margin(problem, path, timing).margin >= problem.margin; };
  ComPath path = build();
  if (fits(path)) return path;

  // Support edges that constrain each knot: those of its phase, or of both adjacent phases.
  constexpr double kReserve = 1e-4;  // between knots the ZMP deviates slightly from a straight line [m]
  struct Edge {
    Eigen::Index knot;
    Vec2 inward;
    double offset;  // inward · zmp ≥ offset
  };
  std::vector<Edge> edges;
  const auto n = static_cast<Eigen::Index>(knots.size());
  const auto keep_inside = [&](Eigen::Index k, const ConvexPolygon& support) {
    const std::vector<Vec2>& corners = support.vertices();
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Vec2 along = (corners[(c + 1) % corners.size()] - corners[c]).normalized();
      const Vec2 inward(-along.y(), along.x());
      edges.push_back({k, inward, inward.dot(corners[c]) + problem.margin + kReserve});
    }
  };
  keep_inside(0, problem.at_start);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double place = problem.knots[static_cast<std::size_t>(k)].t;
    for (std::size_t i = 0; i < problem.phases.size(); ++i) {
      const auto begin = static_cast<double>(i);
      if (place > begin - 1e-9 && place < begin + 1.0 + 1e-9) keep_inside(k, problem.phases[i].support);
    }
  }
  // Unknowns: x of all knots, then y. The vertical path is fixed, so the ZMP is linear in them: zmp = (1 − f) p + f v,
  // where p = (ξ + η)/2.
  Workspace& w = *w_;
  const auto m = static_cast<Eigen::Index>(edges.size());
  w.H.setZero(2 * n, 2 * n);
  w.g.setZero(2 * n);
  w.CE.setZero(4, 2 * n);
  w.ce.setZero(4);
  w.CI.setZero(m, 2 * n);
  w.ci.setZero(m);
  for (int axis = 0; axis < 2; ++axis) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const VrpKnot& knot = knots[static_cast<std::size_t>(k)];
      w.H(axis * n + k, axis * n + k) = knot.weight;
      w.g[axis * n + k] = -knot.weight * knot.wish[axis];
    }
    w.CE.block(2 * axis, axis * n, 2, n) = r.A;
    w.ce.segment<2>(2 * axis) = -r.b.col(axis);
  }
  const double rest = kGravity / (problem.omega * problem.omega);
  std::vector<double> part(knots.size());  // f at each knot
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const double z = path.at(knots[i].t).p.z();
    const double lever = z - v[i].z() + rest;
    if (!(lever > 0.0)) return std::nullopt;
    part[i] = (z - problem.plane) / lever;
  }
  for (Eigen::Index row = 0; row < m; ++row) {
    const Edge& edge = edges[static_cast<std::size_t>(row)];
    const Eigen::Index k = edge.knot;
    const double f = part[static_cast<std::size_t>(k)];
    w.ci[row] = -edge.offset;
    for (int axis = 0; axis < 2; ++axis) {
      const double a = edge.inward[axis];
      w.CI.block(row, axis * n, 1, n) = (0.5 * a * (1.0 - f)) * (r.xi.row(k) + r.eta.row(k));
      w.CI(row, axis * n + k) += a * f;
      w.ci[row] += 0.5 * a * (1.0 - f) * (r.xi0(k, axis) + r.eta0(k, axis));
    }
  }
  w.x.setZero(2 * n);
  w.qp.reset(static_cast<std::size_t>(2 * n), 4, static_cast<std::size_t>(m));
  const auto status = w.qp.solve_quadprog(w.H, w.g, w.CE, w.ce, w.CI, w.ci, w.x);
  if (status != eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL || !w.x.allFinite()) return std::nullopt;
  for (Eigen::Index k = 0; k < n; ++k)
    v[static_cast<std::size_t>(k)].head<2>() << w.x[k], w.x[n + k];
  path = build();
  return fits(path) ? std::optional(path) : std::nullopt;
}

ComPlan correct_duration(const ComProblem& problem, double first, double step, double last, double period) {
  ComPlan plan;
  for (double T = first; T <= last + 1e-9; T += step) {
    ++plan.tried;
    plan.timing = timing_by_shares(problem.phases, static_cast<int>(std::lround(T / period)), period);
    plan.path = com_path(problem, plan.timing);
    plan.zmp = zmp_margin(problem, plan.path, plan.timing);
    plan.feasible = plan.zmp.margin >= problem.margin;
    if (plan.feasible) break;
  }
  return plan;
}

}  // namespace baton
