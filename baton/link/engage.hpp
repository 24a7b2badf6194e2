/// Where a run begins with a robot that stands somewhere, its joints as they are.
#pragma once

#include <optional>
#include <string>

#include "baton/balance/measurement.hpp"
#include "baton/balance/state_source.hpp"
#include "baton/model/robot_model.hpp"
#include "baton/motion/posture.hpp"

namespace baton::link {

/// Whether every joint is near the stance of the robot's profile.
/// @param q joint angles (n) [rad]
[[nodiscard]] bool in_stance(const RobotModel& robot, const VecX& q);

/// What a robot does not measure of what its state is to be estimated from, as the end of a sentence about it; none: it
/// measures all of that.
[[nodiscard]] std::optional<std::string> lacks(const Measurement& measured, StateSource source);

/// The same for what a robot at rest seems to measure in other units.
[[nodiscard]] std::optional<std::string> in_other_units(const Measurement& at_rest, StateSource source);

/// Posture at rest of a robot that stands on both soles: in the stance of its profile if every joint is near it, else
/// with the joints as they were measured.
/// @param start the middle of the soles, on the ground
/// @param q measured joint angles (n) [rad]
/// @throws InputError the soles would not stand flat on the same ground, or the COM is not above them
[[nodiscard]] Posture engage(const RobotModel& robot, const Pose& start, const VecX& q);

}  // namespace baton::link
