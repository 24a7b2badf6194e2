/// The posture that a robot begins with.
#pragma once

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Posture of a configuration: body parts by forward kinematics, both feet standing, at rest.
[[nodiscard]] Posture posture_of(const RobotModel& robot, const VecX& q);

/// Both soles flat at the stance width about `start` (x forward, z up), COM above their midpoint at `com_height`
/// [m] over them, trunk upright, arms at home.
/// @throws InputError the robot cannot stand so: the message names the residual
[[nodiscard]] Posture stand(const RobotModel& robot, const Pose& start, double com_height);

/// The sample of a robot that rests in a posture.
[[nodiscard]] MotionSample resting(const RobotModel& robot, const Posture& posture);

}  // namespace baton
