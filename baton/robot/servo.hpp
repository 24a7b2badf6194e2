/// The drive law: joint target → servo command → motor torque.
///
/// A servo runs faster than the tick and interpolates. A target holds for the end of the tick; `to_end` seconds earlier
/// the desired angle is q + s − to_end·q̇, where s is the balance correction. So
///
///     q_cmd = q + s − to_end·q̇ + q_fold                    [rad]
///     τ     = τ_cmd + kp (q_cmd − q_m) + kd (q̇_cmd − q̇_m)   [N·m]
///
/// with the measured angle q_m and speed q̇_m. The drive decides how the feed-forward torque τ_ff is applied:
///
/// | drive    | τ_cmd | q̇_cmd | q_fold             |
/// |----------|-------|-------|--------------------|
/// | `torque` | τ_ff  | q̇     | 0                  |
/// | `pd`     | 0     | q̇     | τ_ff / kp          |
/// | `stiff`  | 0     | 0     | (τ_ff + kd q̇) / kp |
///
/// A robot with servos of its own receives the `ServoCommand`; a simulator also needs `servo_torque` and
/// `motor_torque`.
#pragma once

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Command to the servo of one joint.
struct ServoCommand {
  double q = 0.0;    ///< angle, including q_fold [rad]
  double dq = 0.0;   ///< speed; zero if the drive takes none [rad/s]
  double tau = 0.0;  ///< feed-forward torque τ_cmd; zero if the drive takes none [N·m]
};

/// @param joint index of the joint
/// @param to_end time to the end of the target's tick, negative afterwards [s]
[[nodiscard]] ServoCommand servo_command(const RobotModel& robot, std::size_t joint, const JointTarget& target,
                                         double to_end);

/// Torque that a servo commands [N·m].
/// @param gains actual gains of the servo; q_fold uses those of the profile
/// @param q measured angle [rad]
/// @param dq measured speed [rad/s]
[[nodiscard]] double servo_torque(const Profile::Gains& gains, const ServoCommand& command, double q, double dq);

/// Commanded torque `asked` clamped to the stall torque [N·m]. The loss with speed is modelled as damping in the
/// joint's dynamics.
[[nodiscard]] double motor_torque(const Motor& motor, double asked);

}  // namespace baton
