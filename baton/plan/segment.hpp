/// A goal made into a segment: contact phases, COM problem, and the paths of swing foot, trunk and hands for any
/// duration.
#pragma once

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/motion.hpp"
#include "baton/plan/com_plan.hpp"

namespace baton {

class Segment {
 public:
  /// Which phases a kind of segment has: step = double–single–double support, lift = double–single, lower =
  /// single–double, air = single, shift and reach = double.
  Segment(const RobotModel& robot, const Posture& from, const Goal& goal);

  [[nodiscard]] const ComProblem& com() const { return com_; }

  /// The phase in which a foot is in the air and moves; none: no foot moves.
  [[nodiscard]] std::optional<std::size_t> swing_phase() const;

  /// Which soles stand at a time [s]; where two phases meet, the later one counts.
  [[nodiscard]] BySide<bool> contact(const Timing& timing, double t) const;

  [[nodiscard]] std::vector<ContactPhase> phases(const Timing& timing) const;

  /// Targets of inverse kinematics at a time [s].
  [[nodiscard]] IkTargets targets(const ComPath& path, const Timing& timing, double t) const;

 private:
  /// The swing foot at `t` of a swing that takes `duration` [s].
  [[nodiscard]] Pose swing(double t, double duration) const;
  /// Least gap of the two soles' outlines along the swing [m].
  [[nodiscard]] double least_gap() const;

  const RobotModel* robot_;
  Posture from_;
  Goal goal_;
  std::vector<BySide<bool>> contact_;  ///< by phase
  ComProblem com_;
  double outward_ = 0.0;  ///< how far the swing bends away from the stance foot, to keep the gap [m]
};

}  // namespace baton
