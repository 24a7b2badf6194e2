/// Reproduces figures of the 2008 paper with the planner, and a test of walking.
#pragma once

#include <filesystem>

#include "baton/robot/simulated_robot.hpp"

namespace baton::app {

/// Fig. 8, duration correction: two steps to the right, the second of which needs more time to keep the ZMP inside the
/// support. Writes `fig8.json` and `fig8.svg`.
/// @throws InputError a file cannot be written
int reproduce_fig8(const std::filesystem::path& out);

/// The demonstration in the room, by the stick alone, in the hands of the scripted operator. Writes its stick as a
/// script, too, which gives the same run with `baton drive`.
/// @param seed of the plant and of what the operator sees
int reproduce_room(const RobotModel& robot, const SimulatedRobot::Parameters& physics, long seed,
                   const std::filesystem::path& out);

/// Thirteen walks of a minute each: forward, sideways, turning, steps, replanning. Reports the trunk's tilt, and the
/// distance from each walk's end to where its motions would have led without slip. Fails above 10° or 3 cm.
/// @param seed of the plant
int reproduce_walks(const RobotModel& robot, const SimulatedRobot::Parameters& physics, long seed,
                    const std::filesystem::path& out);

}  // namespace baton::app
