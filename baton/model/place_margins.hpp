/// Margins to what the map shows, for a robot that is not quite sure where it is.
#pragma once

#include "baton/model/robot_model.hpp"

namespace baton {

/// Least distance of a foothold from terrain edges [m]: the profile's, plus a tenth of the uncertainty as far as steps
/// past an edge remain possible. The whole of it would let no foot near enough to an edge to step past it.
/// @param uncertainty error bound of the robot's position [m]
[[nodiscard]] double edge_margin(const RobotModel& robot, double uncertainty);

/// Distance that trunk and legs keep from obstacles beyond the profile's margin [m]: the uncertainty, up to a tenth of
/// the COM height, so that a robot that has walked far can still work close to them.
/// @param uncertainty error bound of the robot's position [m]
[[nodiscard]] double obstacle_uncertainty(const RobotModel& robot, double uncertainty);

}  // namespace baton
