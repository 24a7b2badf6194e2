/// The drive law: from joint targets to what the servo of a joint is told, and to the torque that it asks of its motor.
///
/// A servo runs faster than the program. A target says where a joint shall be when the tick ends; `to_end` seconds
/// before that, the joint shall be at q + s − to_end·q̇, where s is what balance adds to the angle. So
///
///     q_cmd = q + s − to_end·q̇ + τ_fold         [rad]
///     τ     = τ_cmd + kp (q_cmd − q_m) + kd (q̇ − q̇_m)   [N·m]
///
/// with the measured angle q_m and speed q̇_m. What becomes of the feed-forward torque τ_ff depends on the drive:
///
/// | drive    | τ_cmd | τ_fold    |
/// |----------|-------|-----------|
/// | `torque` | τ_ff  | 0         |
/// | `pd`     | 0     | τ_ff / kp |
/// | `stiff`  | 0     | 0         |
///
/// A simulator needs `servo_torque` and `motor_torque`; a robot that has servos is sent the `ServoCommand` alone.
#pragma once

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// What the servo of one joint is told.
struct ServoCommand {
  double q = 0.0;    ///< angle, with the torque folded in where the drive takes it so [rad]
  double dq = 0.0;   ///< speed [rad/s]
  double tau = 0.0;  ///< feed-forward torque: zero unless the drive takes one [N·m]
};

/// @param joint index of the joint
/// @param to_end time to the end of the tick that the target is for, negative after it [s]
[[nodiscard]] ServoCommand servo_command(const RobotModel& robot, std::size_t joint, const JointTarget& target,
                                         double to_end);

/// Torque that a servo asks of its motor [N·m].
/// @param gains that the servo has; the torque is folded in by those of the profile
/// @param q measured angle [rad]
/// @param dq measured speed [rad/s]
[[nodiscard]] double servo_torque(const Profile::Gains& gains, const ServoCommand& command, double q, double dq);

/// Torque that a motor gives when it is asked for `asked`: at most its stall torque [N·m]. What is lost with speed is
/// the motor's damping, which belongs to the joint's dynamics.
[[nodiscard]] double motor_torque(const Motor& motor, double asked);

}  // namespace baton
