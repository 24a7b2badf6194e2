/// Drift: the difference between where the robot is and where its motions led, from slipping soles and odometry error.
#pragma once

#include "baton/guide/guide.hpp"

namespace baton {

/// Displacement of the soles that counts as a slip [reach of a foot].
inline constexpr double kSlip = 0.2;

/// Correction that a motion which guides the trunk applies for slipped soles: a displacement of the planning frame
/// towards `context.slip_free_frame`, of at most a twentieth of the trunk's reach along, aside and round, each beyond a
/// dead band. Identity for all other commands.
[[nodiscard]] Pose drift_correction(const RobotModel& robot, const GuideContext& context, const Command& command);

}  // namespace baton
