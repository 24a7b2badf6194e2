/// By how much the legs need more torque than the model says: motors that are weaker than stated, servos whose kp is
/// not the profile's (torque that is folded into angles is off by the same factor), masses that are off. One factor for
/// all joints, learned from how the servos' errors follow the torque (docs/balance.md).
#pragma once

#include "baton/model/robot_model.hpp"

namespace baton {

class TorqueScale {
 public:
  /// The robot must outlive the object.
  explicit TorqueScale(const RobotModel& robot);

  /// Learns; once a tick.
  /// @param torque joint torques of the model (n) [N·m]
  /// @param error commanded − measured joint angles (n) [rad]
  void update(const Eigen::Ref<const VecX>& torque, const Eigen::Ref<const VecX>& error);

  /// What a joint needs beyond its torque of the model, as a share of it.
  [[nodiscard]] double excess() const { return excess_; }

 private:
  const RobotModel* robot_;
  double period_;   ///< [1/ω]
  double learned_;  ///< time constant: the time for which it has learned, within its bounds [1/ω]
  double excess_ = 0.0;
};

}  // namespace baton
