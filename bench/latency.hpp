/// How long a change of the command takes to reach the joints.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "baton/model/world.hpp"

namespace baton::bench {

/// Where a change of the command finds the robot.
enum class Situation { at_rest, double_support, foot_in_air };

/// A random change of the command, in the middle of a random run.
struct Change {
  Situation situation = Situation::at_rest;
  bool switched = false;          ///< another part is guided from then on
  std::optional<double> latency;  ///< until the first joint target that is different for it [s]; none: no motion came
  std::optional<std::string> first_against;  ///< the first answer was no motion: the reason; none: it was one
  std::vector<double> plan_us;               ///< CPU time of each answer since the change [µs]
};

/// Drives a run on `ideal`, in default modes, planned on the spot, to a random moment and changes the command there.
/// Two more runs are the same up to the change. In one the old command is held on; the other has the new command, but
/// nothing is planned any more. The latency ends at the first tick whose joint target differs from both: from the first
/// alone it differs as well where the old command would have led to something and the new one leads to nothing.
/// The same seed gives the same change on every platform.
[[nodiscard]] Change change_of_command(const RobotModel& robot, const World& world, std::uint64_t seed);

}  // namespace baton::bench
