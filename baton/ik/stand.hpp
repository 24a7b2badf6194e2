/// Postures at rest, and the initial standing posture.
#pragma once

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Posture of a configuration by forward kinematics, at rest on both feet.
[[nodiscard]] Posture posture_of(const RobotModel& robot, const VecX& q);

/// The standing posture: soles flat, at the stance width about `start` (x forward, z up); COM `com_height` [m] above
/// their midpoint; trunk upright; arms at home.
/// @throws InputError the robot cannot stand that way; the message has the residual
[[nodiscard]] Posture stand(const RobotModel& robot, const Pose& start, double com_height);

/// The motion sample of a robot at rest in a posture.
[[nodiscard]] MotionSample resting(const RobotModel& robot, const Posture& posture);

}  // namespace baton
