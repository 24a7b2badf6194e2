/// Option strings → values.
#pragma once

#include <string>

#include "app/commands.hpp"
#include "baton/proving/answer_faults.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {

/// Planning modes from options.
[[nodiscard]] Modes modes_of(const ModeOptions& options);

/// Loads a robot by name or file; `drive` overrides its profile's drive.
/// @throws InputError no such robot or drive
[[nodiscard]] RobotModel load_robot(const std::string& name_or_file, const std::optional<std::string>& drive);

/// Loads a robot with the drive given by the options or their scenario.
/// @throws InputError no such robot, drive or scenario
[[nodiscard]] RobotModel robot_in(const PhysicsOptions& options, const std::string& name_or_file);

/// sim or ideal.
[[nodiscard]] Simulation::On on_named(const std::string& on);

/// The plant of the options' scenario.
/// @param on sim or ideal
/// @throws InputError a scenario without physics, or no such scenario
[[nodiscard]] SimulatedRobot::Parameters parameters_of(const PhysicsOptions& options, const RobotModel& robot,
                                                       const std::string& on, long seed);

/// Answer faults from options.
[[nodiscard]] AnswerFaults faults_of(const AnswerOptions& options);

/// Source of the state estimate.
/// @throws InputError no such source
[[nodiscard]] StateSource state_named(const std::string& name);

}  // namespace baton::app
