/// Dry friction in the joints: its size is learned from how the servos' errors follow the direction in which the joints
/// are planned to move (docs/balance.md).
#pragma once

#include "baton/model/robot_model.hpp"

namespace baton {

class JointFriction {
 public:
  /// The robot must outlive the object.
  explicit JointFriction(const RobotModel& robot);

  /// Learns; once a tick.
  /// @param speed planned joint speeds at the time of the measurement (n) [rad/s]
  /// @param error commanded − measured joint angles (n) [rad]
  void update(const Eigen::Ref<const VecX>& speed, const Eigen::Ref<const VecX>& error);

  /// Torque that overcomes the friction of a joint at this planned speed [N·m].
  [[nodiscard]] double torque(int joint, double speed) const;

  /// Estimated friction, one share of the stall torque for all joints.
  [[nodiscard]] double share() const { return share_; }

 private:
  /// −1 to 1; less than 1 when it may be about to change.
  [[nodiscard]] double direction(double speed) const;

  const RobotModel* robot_;
  double follows_;  ///< of what is missing, in a tick
  double most_;     ///< bound of the share: what verified motions leave of the stall torque
  double share_ = 0.0;
};

}  // namespace baton
