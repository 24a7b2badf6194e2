/// A goal made into a segment: contact phases, COM problem, and the paths of swing foot, trunk and hands for any
/// duration.
#pragma once

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/ik/moving.hpp"
#include "baton/model/limits.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/motion.hpp"
#include "baton/plan/com_plan.hpp"

namespace baton {

class Segment {
 public:
  /// Which phases a segment has: a foot that stands and lands, double–single–double support (a step); that stands and
  /// stays up, double–single (lift); that is up and lands, single–double (lower, or the rest of a step); that is up and
  /// stays so, single (air); no foot, double (shift, reach).
  /// @param rates how the parts move in `from`: their paths go on from there
  Segment(const RobotModel& robot, const Posture& from, const Goal& goal, const Limits& limits,
          const PartRates& rates = {});

  [[nodiscard]] const Posture& from() const { return from_; }
  [[nodiscard]] const Goal& goal() const { return goal_; }
  [[nodiscard]] const Limits& limits() const { return limits_; }

  [[nodiscard]] const ComProblem& com() const { return com_; }

  /// The duration to be tried first [s].
  [[nodiscard]] double first_duration() const { return first_duration_; }

  /// When the swing foot is highest, and how high that is: time [s] and height [m].
  [[nodiscard]] Vec2 apex(const Timing& timing) const;

  /// The phase in which a foot is in the air and moves; none: no foot moves.
  [[nodiscard]] std::optional<std::size_t> swing_phase() const;

  /// Which soles stand at a time [s]; where two phases meet, the later one counts.
  [[nodiscard]] BySide<bool> contact(const Timing& timing, double t) const;

  [[nodiscard]] std::vector<ContactPhase> phases(const Timing& timing) const;

  /// Targets of inverse kinematics at a time [s].
  [[nodiscard]] IkTargets targets(const ComPath& path, const Timing& timing, double t) const;

 private:
  /// When and how high the apex of a swing that takes `duration` is: [s], [m].
  [[nodiscard]] Vec2 apex(double duration) const;
  /// The swing foot at `t` of a swing that takes `duration` [s].
  [[nodiscard]] Pose swing(double t, double duration) const;
  /// Least gap of the two soles' outlines along the swing [m].
  [[nodiscard]] double least_gap() const;
  /// Whether the swing foot lands beside where it is.
  [[nodiscard]] bool beside() const;

  const RobotModel* robot_;
  Posture from_;
  Goal goal_;
  Limits limits_;
  PartRates rates_;
  std::vector<BySide<bool>> contact_;  ///< by phase
  double first_duration_ = 0.0;
  ComProblem com_;
  double outward_ = 0.0;  ///< how far the swing bends away from the stance foot, to keep the gap [m]
};

}  // namespace baton
