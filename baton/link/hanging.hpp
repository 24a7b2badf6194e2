/// How a robot that hangs in a gantry, its soles in the air, gets to its stance before a run begins.
#pragma once

#include <functional>

#include "baton/link/remote_robot.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/robot/calibration.hpp"

namespace baton::link {

/// The way of the joints from where they are to the stance of the robot's profile: straight, at rest at both ends, with
/// the torques of standing at its end but at the ankles, so that nothing jumps when a run begins there.
class WayToStance {
 public:
  static constexpr double kFastest = 0.4;   ///< speed of the fastest joint, at most [rad/s]
  static constexpr double kQuickest = 2.0;  ///< time that it takes at least [s]

  /// @param q measured joint angles (n) [rad]
  /// @throws InputError a joint is far out of its range, or on the way a link would come too close to another; says
  /// which
  WayToStance(const RobotModel& robot, const VecX& q);

  [[nodiscard]] bool done() const { return t_ >= duration_; }
  /// The target for the end of the next tick; at the end of the way, the last one again.
  [[nodiscard]] JointTarget next();
  /// How far the joints are from where a servo holds those of a robot that hangs, at the end of the way [rad].
  [[nodiscard]] VecX off(const VecX& q) const;

 private:
  void check(const VecX& q);

  const RobotModel* robot_;
  VecX from_, way_, torque_;
  double duration_ = 0.0, t_ = 0.0;
};

/// Lets a robot that follows targets and hangs take its stance.
/// @param errors of its sensors, as far as they are known
/// @param go_on asked each tick; false: the robot is handed back as it is
/// @returns the target that holds it there
/// @throws InputError its soles carry it, or there is no such way
/// @throws LinkError it is gone, damped, follows no longer, does not come there, or shall not go on
JointTarget take_stance(const RobotModel& model, RemoteRobot& robot, const Calibration& errors,
                        const std::function<bool()>& go_on);

}  // namespace baton::link
