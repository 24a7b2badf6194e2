/// The centre of mass of a segment: contact phases, wishes for the VRP, and the check of the point mass's ZMP
/// (docs/theory.md §3, §4).
#pragma once

#include <vector>

#include "baton/math/lip.hpp"
#include "baton/math/polygon.hpp"

namespace baton {

/// A contact phase of a segment whose duration is not known yet.
struct SupportPhase {
  double share = 1.0;     ///< of the duration
  ConvexPolygon support;  ///< where the ZMP may be, on the problem's plane [m]
};

/// Boundary value problem of one segment, for any duration.
struct ComProblem {
  double omega = 1.0;        ///< [rad/s]
  Vec3 p0 = Vec3::Zero();    ///< COM at the start [m]
  Vec3 dp0 = Vec3::Zero();   ///< its velocity [m/s]; the start may be moving
  Vec3 goal = Vec3::Zero();  ///< COM at the end, at rest [m]
  double plane = 0.0;        ///< height of the ZMP's plane [m]
  double margin = 0.0;       ///< of the ZMP inside the support [m]
  std::vector<SupportPhase> phases;
  std::vector<VrpKnot> knots;  ///< wishes; `t` is a share of the duration, 0…1
};

/// Borders of the phases [ticks], the first 0, for a duration of `ticks`; every phase has at least one tick.
[[nodiscard]] std::vector<int> phase_borders(const std::vector<SupportPhase>& phases, int ticks);

/// The COM path of a duration of `ticks` of `period` [s]. Knots that lie on a phase border move with it to the
/// nearest tick.
[[nodiscard]] ComPath com_path(const ComProblem& problem, int ticks, double period);

/// Least distance of the point mass's ZMP from the edge of the support [m], negative outside, sampled at the
/// knots and at least every 20 ms; at the border of two phases the ZMP must be in both supports.
struct ZmpMargin {
  double margin = 0.0;
  double t = 0.0;  ///< where it is least [s]
};
[[nodiscard]] ZmpMargin zmp_margin(const ComProblem& problem, const ComPath& path, double period);

/// The paper's duration correction for the point mass: the first of T, T + ΔT, … ≤ T_max whose ZMP stays inside.
struct ComPlan {
  bool feasible = false;
  int ticks = 0;
  int tried = 0;
  ComPath path;
  ZmpMargin zmp;
};
/// @param first, step, last durations [s]
[[nodiscard]] ComPlan correct_duration(const ComProblem& problem, double first, double step, double last,
                                       double period);

}  // namespace baton
