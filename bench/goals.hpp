/// Goals to plan for, drawn at random: what the guide makes of a random command in a random posture.
#pragma once

#include <cstdint>
#include <vector>

#include "baton/guide/guide.hpp"

namespace baton::bench {

struct Task {
  Posture from;
  Goal goal;
};

/// Steps, lifts, landings, shifts of the weight and reaches that need one, on level ground, the COM as high at the end
/// as at the start. The robot rests: feet somewhere in their regions (or one in the air), COM somewhere in the stand-on
/// region, trunk upright, arms at home. Nothing says that a motion exists.
/// @param world level
[[nodiscard]] std::vector<Task> level_tasks(const RobotModel& robot, const World& world, int count, std::uint64_t seed);

}  // namespace baton::bench
