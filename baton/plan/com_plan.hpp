/// The centre of mass of a segment: contact phases, wishes for the VRP, and its knots inside the support polygons
/// (docs/theory.md §3, §4).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "baton/math/lip.hpp"
#include "baton/math/polygon.hpp"

namespace baton {

/// A contact phase of a segment whose duration is not known yet.
struct SupportPhase {
  double share = 1.0;     ///< of the duration, unless a timing says otherwise
  ConvexPolygon support;  ///< where the ZMP may be, on the problem's plane [m]
};

/// When the phases of a segment begin and end.
struct Timing {
  double period = 0.005;    ///< of a tick [s]
  std::vector<int> border;  ///< [ticks], from 0 to the duration: one more than there are phases

  [[nodiscard]] int ticks() const { return border.back(); }
  [[nodiscard]] double duration() const { return period * ticks(); }
  /// Time of a place counted in phases: 1.5 is the middle of the second one [s].
  [[nodiscard]] double at(double place) const;
};

/// Boundary value problem of one segment, for any timing.
struct ComProblem {
  double omega = 1.0;        ///< [rad/s]
  Vec3 p0 = Vec3::Zero();    ///< COM at the start [m]
  Vec3 dp0 = Vec3::Zero();   ///< its velocity [m/s]; the start may be moving
  Vec3 goal = Vec3::Zero();  ///< COM at the end, at rest [m]
  double plane = 0.0;        ///< height of the ZMP's plane [m]
  double margin = 0.0;       ///< of the ZMP inside the support [m]
  ConvexPolygon at_start;  ///< where the ZMP may be at the start besides, if it has corners: the support until then [m]
  std::vector<SupportPhase> phases;
  std::vector<VrpKnot> knots;  ///< wishes; `t` is a place counted in phases: 0 … number of phases
};

/// The timing by the phases' own shares, for a duration of `ticks`; every phase has at least one tick.
[[nodiscard]] Timing timing_by_shares(const std::vector<SupportPhase>& phases, int ticks, double period);

/// The COM path whose knots are nearest to their wishes, wherever that takes the ZMP.
[[nodiscard]] ComPath com_path(const ComProblem& problem, const Timing& timing);

/// Least distance of the ZMP from the edge of the support [m], negative outside, sampled at the
/// knots and at least every 20 ms; at the border of two phases the ZMP must be in both supports.
struct ZmpMargin {
  double margin = 0.0;
  double t = 0.0;  ///< where it is least [s]
};
[[nodiscard]] ZmpMargin zmp_margin(const ComProblem& problem, const ComPath& path, const Timing& timing);

/// The same cost as `com_path` with the supports as inequalities at the knots: a small quadratic program. Between
/// knots the VRP is linear and the supports are convex.
class BoundedCom {
 public:
  BoundedCom();
  ~BoundedCom();

  /// None if no knots keep the ZMP inside by the problem's margin.
  /// @param offset of the whole body's VRP from the point mass's
  [[nodiscard]] std::optional<ComPath> path(const ComProblem& problem, const Timing& timing,
                                            const VrpOffset& offset = {});

 private:
  struct Workspace;
  std::unique_ptr<Workspace> w_;
};

/// The paper's duration correction for the point mass: the first of T, T + ΔT, … ≤ T_max whose ZMP stays inside.
struct ComPlan {
  bool feasible = false;
  int tried = 0;
  Timing timing;
  ComPath path;
  ZmpMargin zmp;
};
/// @param first, step, last durations [s]
[[nodiscard]] ComPlan correct_duration(const ComProblem& problem, double first, double step, double last,
                                       double period);

}  // namespace baton
