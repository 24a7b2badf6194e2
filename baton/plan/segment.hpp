/// Goal → segment: contact phases, COM problem, and paths of swing foot, trunk and hands for any duration.
#pragma once

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/ik/moving.hpp"
#include "baton/model/limits.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/motion.hpp"
#include "baton/plan/com_plan.hpp"

namespace baton {

/// How far a sole reaches outward from its centre [m].
[[nodiscard]] double outer_edge(const RobotModel& robot, Side side);

class Segment {
 public:
  /// The phases follow from the swing foot. It stands and lands: double–single–double support (step). It stands and
  /// stays up: double–single (lift). It is up and lands: single–double (lower, or rest of a step). It is up and stays
  /// up: single (air). None: double (shift, reach).
  /// @param rates velocities of the parts at `from`, from which their paths continue
  Segment(const RobotModel& robot, const Posture& from, const Goal& goal, const Limits& limits,
          const PartRates& rates = {});

  [[nodiscard]] const Posture& from() const { return from_; }
  [[nodiscard]] const Goal& goal() const { return goal_; }
  [[nodiscard]] const Limits& limits() const { return limits_; }

  /// Boundary value problem of the robot's COM, which is the model's displaced by `com_offset()`.
  [[nodiscard]] const ComProblem& com() const { return com_; }
  /// Offset of the robot's COM from the model's, in the planning frame [m].
  [[nodiscard]] Vec3 com_offset() const { return {limits_.com_offset.x(), limits_.com_offset.y(), 0.0}; }

  /// First duration to try [s].
  [[nodiscard]] double first_duration() const { return first_duration_; }

  /// Swing apex: time [s] and height [m].
  [[nodiscard]] Vec2 apex(const Timing& timing) const;

  /// The swing phase; none: no foot moves.
  [[nodiscard]] std::optional<std::size_t> swing_phase() const;

  /// Stance soles at time t [s]; at a phase boundary the later phase counts.
  [[nodiscard]] BySide<bool> contact(const Timing& timing, double t) const;

  [[nodiscard]] std::vector<ContactPhase> phases(const Timing& timing) const;

  /// Targets of inverse kinematics at time t [s].
  [[nodiscard]] IkTargets targets(const ComPath& path, const Timing& timing, double t) const;

 private:
  /// Apex of a swing of `duration` [s]: time [s] and height [m].
  [[nodiscard]] Vec2 apex(double duration) const;
  /// Swing foot pose at time t of a swing of `duration` [s].
  [[nodiscard]] Pose swing(double t, double duration) const;
  /// Cuts off the support along the outer edges of the soles in contact, so that a ZMP `zmp_plan` inside the rest is
  /// `Limits::zmp_outward` inside those edges: room for the stabiliser to bring back a robot that tips outward.
  [[nodiscard]] ConvexPolygon within_outer_edges(ConvexPolygon support, const BySide<Pose>& sole,
                                                 const BySide<bool>& contact) const;
  /// Least gap between the sole outlines along the swing [m].
  [[nodiscard]] double least_gap() const;
  /// Height difference below which footholds are level [m].
  [[nodiscard]] double level() const;
  /// Whether a foot in the air lands beside its current position.
  [[nodiscard]] bool beside() const;

  const RobotModel* robot_;
  Posture from_;
  Goal goal_;
  Limits limits_;
  PartRates rates_;
  std::vector<BySide<bool>> contact_;  ///< by phase
  double first_duration_ = 0.0;
  ComProblem com_;
  double outward_ = 0.0;  ///< outward bend of the swing, away from the stance foot, to keep the gap [m]
};

}  // namespace baton
