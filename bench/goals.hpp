/// Random planning tasks: the guide's goals for random commands in random postures.
#pragma once

#include <cstdint>
#include <vector>

#include "baton/guide/guide.hpp"

namespace baton::bench {

struct Task {
  Posture from;
  Goal goal;
};

/// Steps, lifts, landings, weight shifts, and reaches that need a weight shift, on level ground with equal COM height
/// at start and end. The robot is at rest: feet anywhere in their regions (or one in the air), COM anywhere in the
/// stand-on region, trunk upright, arms at home. A feasible motion may not exist.
/// @param world level
[[nodiscard]] std::vector<Task> level_tasks(const RobotModel& robot, const World& world, int count, std::uint64_t seed);

}  // namespace baton::bench
