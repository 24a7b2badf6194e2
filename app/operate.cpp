#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/door_task.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "baton/ik/stand.hpp"
#include "baton/input/script.hpp"
#include "baton/proving/room_operator.hpp"

namespace baton::app {

int operate(const OperateOptions& o) {
  const RobotModel robot = robot_in(o.physics, o.robot);
  const World world = World::load(o.task);

  // A random place on the stage, not quite facing the steps.
  std::mt19937_64 random(static_cast<std::uint64_t>(o.seed));
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Pose start = world.site("start");
  if (!o.exact_start) {
    start.p += Vec3(-0.07 + 0.07 * unit(random), 0.10 * unit(random), 0);
    start.R = start.R * rotation_z(0.25 * unit(random));
  }
  const Posture posture = stand(robot, start, robot.profile().stance.com_height);

  Simulation simulation(robot, world, on_named(o.on),
                        {.start = posture,
                         .physics = parameters_of(o.physics, robot, o.on, o.seed),
                         .session = {modes_of(o.modes), state_named(o.physics.state)}});
  Session& session = simulation.session();
  check_distinct({{"--report", o.report}, {"--trace", o.trace}, {"--script", o.script}},
                 files_read(o.robot, robot, world));
  Outputs outputs(simulation, o.report, o.trace, std::nullopt);
  std::optional<std::ofstream> script;
  if (o.script) script = open_stream(*o.script, "--script");
  RoomOperator::Parameters parameters;
  parameters.eyes = Eyes::Parameters::with_error(1e-3 * o.sight);
  parameters.foot_by_foot = o.foot_by_foot;
  RoomOperator person(robot, world, static_cast<std::uint64_t>(o.seed) + 1, parameters);
  Kinematics kinematics(robot);
  Command last;
  bool first = true;
  DoorTask task(robot, world);
  const auto look = [&] {
    kinematics.set(simulation.truth().q);
    task.look(kinematics);
  };
  look();
  std::string_view doing;
  bool refused = false;
  const auto wall = std::chrono::steady_clock::now();
  while (session.t() < o.seconds && !task.reached() && !session.fallen() && !interrupted) {
    const Command command = person.decide(session.view());
    if (person.doing() != doing) {
      doing = person.doing();
      spdlog::info("{:6.1f} s: the operator {}", session.t(), doing);
    }
    if (script && (first || !(command == last))) *script << script_line(session.t(), command) << '\n';
    first = false;
    last = command;
    session.step(command);
    const auto& refusal = session.navigator().refusal();
    if (refusal && !refused) {
      spdlog::debug("{:6.2f} s: {} refused: {} {} {:.4f}, limit {:.4f}", session.t(), to_string(command.guide),
                    to_string(refusal->reason), place(*refusal), refusal->value, refusal->limit);
    }
    refused = refusal != nullptr;
    look();
  }
  const bool reached = task.reached() && !session.fallen();
  const nlohmann::json extra = {{"reached", reached}, {"hand_error_m", task.error()}, {"task", o.task}};
  outputs.write(world.name(), o.on, o.seed, seconds_since(wall), extra);
  if (script) close_stream(*script, *o.script, "--script");
  fmt::print("{} after {:.1f} s: the hand is {:.1f} mm from the door, {}\n", reached ? "reached" : "not reached",
             session.t(), 1e3 * task.error(), session.fallen() ? "fallen: " + simulation.truth().fall : "on its feet");
  if (session.fallen()) return kFallen;
  return reached ? kDone : kFailed;
}

}  // namespace baton::app
