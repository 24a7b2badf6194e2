/// The values that options name.
#pragma once

#include <string>

#include "app/commands.hpp"
#include "baton/proving/answer_faults.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {

/// The modes that options name.
[[nodiscard]] Modes modes_of(const ModeOptions& options);

/// The robot of this name or file, with another kind of drive than its profile's if one is named.
/// @throws InputError no such robot or drive
[[nodiscard]] RobotModel load_robot(const std::string& name_or_file, const std::optional<std::string>& drive);

/// The robot with the drive that options or their scenario name.
/// @throws InputError no such robot, drive or scenario
[[nodiscard]] RobotModel robot_in(const PhysicsOptions& options, const std::string& name_or_file);

/// sim or ideal.
[[nodiscard]] Simulation::On on_named(const std::string& on);

/// The plant that options name.
/// @param on sim or ideal
/// @throws InputError a scenario where there is no physics, or no such scenario
[[nodiscard]] SimulatedRobot::Parameters parameters_of(const PhysicsOptions& options, const RobotModel& robot,
                                                       const std::string& on, long seed);

/// What goes wrong with answers by these options.
[[nodiscard]] AnswerFaults faults_of(const AnswerOptions& options);

/// Where the state of the robot comes from.
/// @throws InputError no such source
[[nodiscard]] StateSource state_named(const std::string& name);

}  // namespace baton::app
