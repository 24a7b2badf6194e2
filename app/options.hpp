/// Option strings → values.
#pragma once

#include <map>
#include <string>

#include "app/commands.hpp"
#include "baton/link/token.hpp"
#include "baton/proving/answer_faults.hpp"
#include "baton/proving/scenario.hpp"
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

/// Whether the plant is `real`: in physics, unless `model` is asked for.
[[nodiscard]] bool is_real(const PhysicsOptions& options, const std::string& on);

/// The plant's name, real or model.
[[nodiscard]] std::string plant_name(const PhysicsOptions& options, const std::string& on);

/// Plant and scenario of a simulated robot, for the settings of a recording; nothing if it is ideal.
/// @param on sim or ideal
[[nodiscard]] std::map<std::string, std::string> plant_settings(const PhysicsOptions& options, const std::string& on);

/// Those of another end's settings that are about its plant: no other can change what a recording says.
[[nodiscard]] std::map<std::string, std::string> plant_settings(const std::map<std::string, std::string>& settings);

/// Checks that a plant or scenario is only asked for in physics.
/// @param on sim or ideal
/// @throws InputError it is asked for without
void check_physics(const PhysicsOptions& options, const std::string& on);

/// The options' plant with their scenario.
/// @param on sim or ideal
/// @throws InputError a plant or scenario without physics, no such scenario, or `times` for one that has no size
[[nodiscard]] SimulatedRobot::Parameters parameters_of(const PhysicsOptions& options, const RobotModel& robot,
                                                       const std::string& on, long seed);

/// The calibration of `--calibration`, if it is given.
/// @param on sim or ideal
/// @throws InputError bad file, or a robot that is ideal
[[nodiscard]] std::optional<Calibration> calibration_in(const std::optional<std::filesystem::path>& file,
                                                        const RobotModel& robot, const std::string& on);

/// Whether `--on` names the address of a robot's end.
[[nodiscard]] bool is_address(const std::string& on);

using link::token_in;

/// Answer faults from options.
[[nodiscard]] AnswerFaults faults_of(const AnswerOptions& options);

/// @param live plan asynchronously, dropping late answers; else synchronously
[[nodiscard]] std::unique_ptr<Planning> planner_of(const RobotModel& robot, const World& world, Modes modes, bool live);

/// Source of the state estimate.
/// @throws InputError no such source
[[nodiscard]] StateSource state_named(const std::string& name);

/// Checks that a scenario can be scaled.
/// @throws InputError it has no size, and `times` is not 1
void check_times(const Scenario& scenario, double times);

}  // namespace baton::app
