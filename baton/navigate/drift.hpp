/// Where the robot is against where its motions led: soles slide, and odometry is not exact.
#pragma once

#include "baton/guide/guide.hpp"

namespace baton {

/// Displacement of the soles that counts as a slip [reach of a foot].
inline constexpr double kSlip = 0.2;
/// Displacement and turn of the soles that are not corrected [COM height, rad].
inline constexpr double kInPlace = 1e-3;

/// What a motion that guides the trunk corrects of the drift by sliding soles: a move of the planning frame towards
/// `context.slip_free_frame`, by at most a twentieth of the trunk's reach. Other commands correct nothing.
[[nodiscard]] Pose drift_correction(const RobotModel& robot, const GuideContext& context, const Command& command);

/// An uncertainty of the robot's place, by which edges are kept farther away, but no more than still leaves room for
/// steps past them [m].
[[nodiscard]] double bounded_uncertainty(const RobotModel& robot, double uncertainty);

}  // namespace baton
