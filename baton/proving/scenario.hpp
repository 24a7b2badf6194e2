/// Scenarios: physics that deviates from the model (docs/balance.md).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "baton/input/device.hpp"
#include "baton/robot/plant.hpp"

namespace baton {

/// What the stick does meanwhile.
enum class Driving {
  random,  ///< random stick (docs/soak.md)
  stand,   ///< centred
  walk,    ///< guides the trunk forward all the time
  swing,   ///< guides a foot in the air, fore and aft
  shift,   ///< guides the trunk to and fro with pauses; no steps
};

/// What a scenario is drawn from.
struct Draw;

struct Scenario {
  std::string_view name;
  std::string_view what;  ///< in a few words, with numbers for mighty
  Driving driving = Driving::random;
  double seconds = 60.0;  ///< default duration [s]
  /// Adds its deviation to a plant. Null: the plant stays as it is.
  void (*deviate)(Plant& plant, Draw& draw) = nullptr;
};

[[nodiscard]] const std::vector<Scenario>& scenarios();

/// @throws InputError no such scenario
[[nodiscard]] const Scenario& scenario_named(const std::string& name);

/// The plant of a scenario. Lengths, forces and impulses scale with the robot.
/// @param times scales the deviation from the model: differences are multiplied by it, and ratios raised to its power,
/// so that masses and stiffnesses stay positive. 0: none
/// @param base what it is added to
[[nodiscard]] Plant plant_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed, double times = 1.0,
                             const Plant& base = {});

/// The plant of a run.
/// @param real whether sensors and actuators err as the profile states; else the model is exact
/// @param scenario on top of that; may be null
[[nodiscard]] Plant plant_of(bool real, const Scenario* scenario, const RobotModel& robot, std::uint64_t seed,
                             double times);

/// The stick of a run in this scenario; read it once per tick.
[[nodiscard]] std::unique_ptr<Device> stick_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed);

/// The robot with another drive. If the drive changes to `stiff`, kp becomes kStiff times as large, and
/// kd √kStiff times, which keeps the damping ratio.
[[nodiscard]] RobotModel with_drive(const RobotModel& robot, Drive drive);
/// Stiffer servos cannot move the ZMP across the play of `real` (docs/balance.md).
inline constexpr double kStiff = 2.0;

/// The drive of the robot in this scenario.
[[nodiscard]] Drive drive_of(const Scenario& scenario, const RobotModel& robot);

}  // namespace baton
