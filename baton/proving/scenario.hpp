/// Physics that differs from the model: what a robot may meet (docs/balance.md).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "baton/input/device.hpp"
#include "baton/robot/plant.hpp"

namespace baton {

/// What goes on at the stick meanwhile.
enum class Driving {
  random,  ///< docs/soak.md
  stand,   ///< nothing
  walk,    ///< the trunk is guided forward, all the time
  swing,   ///< a foot is guided in the air, fore and aft
  shift,   ///< the trunk is guided to and fro, between moments of rest; no step is due
};

struct Scenario {
  std::string_view name;
  std::string_view what;  ///< in a few words, with numbers for mighty
  Driving driving = Driving::random;
  double seconds = 60.0;  ///< how long it takes, unless something else is asked for
};

[[nodiscard]] const std::vector<Scenario>& scenarios();

/// @throws InputError there is none of this name
[[nodiscard]] const Scenario& scenario_named(const std::string& name);

/// The plant of a scenario. Lengths and impulses scale with the robot.
/// @param times factor on how far it is from the model
[[nodiscard]] Plant plant_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed, double times = 1.0);

/// The stick of a run in this scenario, to be read once a tick.
[[nodiscard]] std::unique_ptr<Device> stick_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed);

/// The robot with another kind of drive. A stiff drive in place of another has servos kStiff times as stiff.
[[nodiscard]] RobotModel with_drive(const RobotModel& robot, Drive drive);
inline constexpr double kStiff = 8.0;

/// The drive of the robot in this scenario.
[[nodiscard]] Drive drive_of(const Scenario& scenario, const RobotModel& robot);

}  // namespace baton
