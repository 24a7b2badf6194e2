#include "app/options.hpp"

#include <fmt/format.h>

#include <utility>

#include "baton/model/error.hpp"
#include "baton/run/planning_thread.hpp"

namespace baton::app {

Modes modes_of(const ModeOptions& o) {
  return {o.duration == "search" ? DurationRule::search : DurationRule::paper,
          o.on_limit == "discard" ? OnLimit::discard : OnLimit::shrink, o.gait == "flow" ? Gait::flow : Gait::stop};
}

std::unique_ptr<Planning> planner_of(const RobotModel& robot, const World& world, Modes modes, bool live) {
  if (live) return std::make_unique<PlanningThread>(robot, world, modes);
  return std::make_unique<DirectPlanning>(robot, world, modes);
}

RobotModel load_robot(const std::string& name_or_file, const std::optional<std::string>& drive) {
  RobotModel robot = RobotModel::load(name_or_file);
  return drive ? with_drive(robot, drive_named(*drive, "--drive")) : std::move(robot);
}

RobotModel robot_in(const PhysicsOptions& options, const std::string& name_or_file) {
  RobotModel robot = load_robot(name_or_file, options.drive);
  if (!options.scenario) return robot;
  const Drive drive = drive_of(scenario_named(*options.scenario), robot);
  return drive == robot.profile().drive ? std::move(robot) : with_drive(robot, drive);
}

Simulation::On on_named(const std::string& on) {
  return on == "sim" ? Simulation::On::sim : Simulation::On::ideal;
}

bool is_real(const PhysicsOptions& options, const std::string& on) {
  return on == "sim" && options.plant.value_or("real") == "real";
}

std::string plant_name(const PhysicsOptions& options, const std::string& on) {
  return is_real(options, on) ? "real" : "model";
}

std::map<std::string, std::string> plant_settings(const PhysicsOptions& options, const std::string& on) {
  if (on != "sim") return {};
  std::map<std::string, std::string> settings{{"plant", plant_name(options, on)}};
  if (options.scenario) settings.insert({{"scenario", *options.scenario}, {"times", fmt::format("{}", options.times)}});
  return settings;
}

std::map<std::string, std::string> plant_settings(const std::map<std::string, std::string>& settings) {
  std::map<std::string, std::string> plant;
  for (const char* name : {"plant", "scenario", "times"}) {
    if (const auto found = settings.find(name); found != settings.end()) plant.insert(*found);
  }
  return plant;
}

void check_times(const Scenario& scenario, double times) {
  if (scenario.deviate == nullptr && times != 1.0)
    throw InputError(fmt::format("--times {}: the scenario {} has no size that could be scaled", times, scenario.name));
}

void check_physics(const PhysicsOptions& options, const std::string& on) {
  if (is_address(on) && options.times != 1.0)
    throw InputError(
        fmt::format("--times {} with --on {}: must be given at the robot's end, to baton robot", options.times, on));
  for (const auto& [option, value] : {std::pair("--scenario", options.scenario), std::pair("--plant", options.plant)}) {
    if (value && is_address(on))
      throw InputError(
          fmt::format("{} {} with --on {}: must be given at the robot's end, to baton robot", option, *value, on));
    if (value && on != "sim")
      throw InputError(fmt::format("{} {} with --on {}: must be --on sim, it needs physics", option, *value, on));
  }
}

SimulatedRobot::Parameters parameters_of(const PhysicsOptions& options, const RobotModel& robot, const std::string& on,
                                         long seed) {
  check_physics(options, on);
  if (!options.scenario && options.times != 1.0)
    throw InputError(fmt::format("--times {} needs --scenario", options.times));
  const Scenario* scenario = options.scenario ? &scenario_named(*options.scenario) : nullptr;
  if (scenario != nullptr) check_times(*scenario, options.times);
  SimulatedRobot::Parameters parameters;
  parameters.plant = plant_of(is_real(options, on), scenario, robot, static_cast<std::uint64_t>(seed), options.times);
  return parameters;
}

std::optional<Calibration> calibration_in(const std::optional<std::filesystem::path>& file, const RobotModel& robot,
                                          const std::string& on) {
  if (!file) return std::nullopt;
  if (on == "ideal") {
    throw InputError(fmt::format("--calibration {} with --on {}: must be --on sim, an ideal robot's sensors are exact",
                                 file->string(), on));
  }
  return Calibration::load(*file, robot);
}

bool is_address(const std::string& on) {
  return on.starts_with("tcp://");
}

AnswerFaults faults_of(const AnswerOptions& options) {
  return {1e-3 * options.delay_ms, options.loss};
}

StateSource state_named(const std::string& name) {
  for (const StateSource source : {StateSource::sensors, StateSource::torques, StateSource::perfect}) {
    if (name == to_string(source)) return source;
  }
  throw InputError(fmt::format("--state {}: must be sensors, torques or perfect", name));
}

}  // namespace baton::app
