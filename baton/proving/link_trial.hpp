/// A trial of the connection between a driver and a robot's end that goes on in real time: a random stick, a virtual
/// clock, and whatever may happen to messages on their way. All by a seed; only the physics and the robot's end are
/// real.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "baton/link/message.hpp"
#include "baton/model/robot_model.hpp"
#include "baton/model/world.hpp"

namespace baton {

/// What happens to a connection.
enum class LinkFault {
  stall,    ///< nothing arrives for up to 3 s, then all of it
  cut,      ///< it is closed; the driver comes back after up to 3 s
  corrupt,  ///< a bit is turned over
  lose,     ///< some bytes are missing
  repeat,   ///< what was sent at once comes twice
  swap,     ///< what was sent at once comes after what was sent later
  clock,    ///< the robot's end is late by up to 1 s, as if its process had been stopped
  stick,    ///< the driver has no stick for up to 2 s
};

inline constexpr std::array<std::string_view, 8> kLinkFaults{"stall",  "cut",  "corrupt", "lose",
                                                             "repeat", "swap", "clock",   "stick"};

struct LinkTrial {
  std::uint64_t seed = 0;
  link::NavigationOptions navigation{};
  double seconds = 10.0;  ///< driven; then the driver is gone
};

struct LinkTrialResult {
  std::string fall;              ///< how the robot fell; "": it did not
  bool rests = false;            ///< at the end, on both feet, some seconds after the driver was gone
  double delay = 0.0;            ///< of each message, at least [s]
  double jitter = 0.0;           ///< and up to this much more [s]
  std::array<long, 8> faults{};  ///< by kind
  long motions = 0;              ///< that were committed
  long stale = 0;                ///< periods of the virtual clock after which the stick was too old
  long drivers = 0;              ///< that took over, one after the other
  std::vector<std::string> log;  ///< of the robot's end
};

/// On the plant `real`, with answers of the planner that take up to 30 ms. A fault happens every 1.5 s on average; half
/// of the connections have a delay of up to 50 ms, the others of up to 0.5 s.
[[nodiscard]] LinkTrialResult run_link_trial(const RobotModel& robot, const World& world, const LinkTrial& trial);

}  // namespace baton
