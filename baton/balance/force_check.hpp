/// Plausibility of the forces under the soles and of the motor torques, against each other and against the plan.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/balance/sole_wrenches.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class ForceCheck {
 public:
  /// The robot must outlive the object.
  explicit ForceCheck(const RobotModel& robot);

  /// Whether the forces are in range; centres of pressure on the soles; not constant while the plan moves; and if the
  /// load of a sole is far from the plan, the motor torques agree.
  /// @param measurement with joint angles that are believed
  /// @param planned sample of this tick
  [[nodiscard]] bool forces_accepted(const Measurement& measurement, const MotionSample& planned);
  /// Whether all torques are finite and at most 1.5 times the stall torques.
  [[nodiscard]] bool torques_accepted(const VecX& torque) const;

  /// The contact wrenches that the plan needs, in the sole frames, moment about the sole's centre.
  [[nodiscard]] BySide<Wrench> planned_forces(const MotionSample& planned);
  /// The motor torques that the plan needs (n) [N·m].
  void planned_torques(const MotionSample& planned, VecX& torque);

 private:
  [[nodiscard]] bool in_range(const BySide<Wrench>& sole) const;
  /// Vertical force on each sole, by where the planned ZMP is between them [weight].
  [[nodiscard]] static BySide<double> planned_load(const MotionSample& planned);
  /// Vertical force on each sole, by the motor torques [weight].
  [[nodiscard]] BySide<double> felt_load(const Measurement& measurement, const MotionSample& planned);
  /// Planned contact wrench on each sole, moment about the origin. Sets `kinematics_`.
  [[nodiscard]] BySide<Wrench> planned_contact(const MotionSample& planned);

  const RobotModel* robot_;
  double period_;
  double weight_;
  Kinematics kinematics_;
  SoleWrenches wrenches_;
  VecX q_;               ///< configuration (nq)
  BySide<Wrench> last_;  ///< reading one tick ago
  int same_ = 0;         ///< ticks in a row with the same reading, but zero
  int unfelt_ = 0;       ///< ticks in a row in which motor torques contradicted the forces
};

}  // namespace baton
