/// Latency from a change of the command to the joint targets.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "baton/model/world.hpp"

namespace baton::bench {

/// State of the robot when the command changes.
enum class Situation { at_rest, double_support, foot_in_air };

/// A random change of the command during a random run.
struct Change {
  Situation situation = Situation::at_rest;
  bool switched = false;                     ///< the guided part changes
  std::optional<double> latency;             ///< to the first joint target affected [s]; none: no motion
  std::optional<std::string> first_against;  ///< reason if the first answer was not a motion
  std::vector<double> plan_us;               ///< CPU time of each answer since the change [µs]
};

/// Drives a run on `ideal` in default modes with synchronous planning, and changes the command at a random time. Two
/// reference runs are identical up to the change: one keeps the old command; the other takes the new one but stops
/// planning. The latency ends at the first tick whose joint target differs from both references: it would differ from
/// the first alone also where the old command leads to a motion and the new one to none. A seed gives the same change
/// on every platform.
[[nodiscard]] Change change_of_command(const RobotModel& robot, const World& world, std::uint64_t seed);

}  // namespace baton::bench
