/// COM trajectory of a segment: contact phases, desired VRP knots, and VRP knots within the support polygons
/// (docs/theory.md §3, §4).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "baton/math/lip.hpp"
#include "baton/math/polygon.hpp"

namespace baton {

/// A contact phase of a segment of yet unknown duration.
struct SupportPhase {
  double share = 1.0;     ///< default share of the duration
  ConvexPolygon support;  ///< admissible ZMP region on the problem's plane [m]
};

/// Phase boundaries of a segment.
struct Timing {
  double period = 0.005;    ///< tick period [s]
  std::vector<int> border;  ///< [ticks], from 0 to the duration; one more entry than phases

  [[nodiscard]] int ticks() const { return border.back(); }
  [[nodiscard]] double duration() const { return period * ticks(); }
  /// Time [s] of a phase coordinate: 1.5 is the middle of the second phase.
  [[nodiscard]] double at(double place) const;
};

/// Boundary value problem of a segment, for any timing.
struct ComProblem {
  double omega = 1.0;        ///< [rad/s]
  Vec3 p0 = Vec3::Zero();    ///< COM at the start [m]
  Vec3 dp0 = Vec3::Zero();   ///< COM velocity at the start [m/s]; need not be zero
  Vec3 goal = Vec3::Zero();  ///< COM at the end, at rest [m]
  double plane = 0.0;        ///< height of the ZMP plane [m]
  double margin = 0.0;       ///< ZMP margin inside the support [m]
  ConvexPolygon at_start;    ///< if not empty, also allowed at the start: previous support [m]
  std::vector<SupportPhase> phases;
  std::vector<VrpKnot> knots;  ///< desired; `t` is a phase coordinate: 0 … number of phases
};

/// Divides `ticks` by the phases' default shares; each phase gets at least one tick.
[[nodiscard]] Timing timing_by_shares(const std::vector<SupportPhase>& phases, int ticks, double period);

/// The COM path whose knots are closest to the desired ones, without ZMP constraints.
[[nodiscard]] ComPath com_path(const ComProblem& problem, const Timing& timing);

/// Least distance of the ZMP from the support's edge [m], negative outside, sampled at the knots and at least every 20
/// ms. At a phase boundary the ZMP must be in both supports.
struct ZmpMargin {
  double margin = 0.0;
  double t = 0.0;  ///< time of the minimum [s]
};
[[nodiscard]] ZmpMargin zmp_margin(const ComProblem& problem, const ComPath& path, const Timing& timing);

/// Minimises the cost of `com_path` with the supports as constraints at the knots: a small quadratic program. The knots
/// suffice because the VRP is linear between them and supports are convex.
class BoundedCom {
 public:
  BoundedCom();
  ~BoundedCom();

  /// None if no knots keep the ZMP inside with the problem's margin.
  /// @param offset whole-body VRP minus point-mass VRP
  [[nodiscard]] std::optional<ComPath> path(const ComProblem& problem, const Timing& timing,
                                            const VrpOffset& offset = {});

 private:
  struct Workspace;
  std::unique_ptr<Workspace> w_;
};

/// The paper's duration correction for the point mass: the first of T, T + ΔT, … ≤ T_max that keeps the ZMP inside.
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
