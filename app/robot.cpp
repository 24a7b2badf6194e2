#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/robots_end.hpp"
#include "baton/ik/stand.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/model/error.hpp"

namespace baton::app {
namespace {

constexpr Socket::Time kAnswering{500};  ///< longest time without a measurement of a robot in real time

/// The robot that follows targets at `--on`.
/// @param parameters those that depend on it are set
/// @throws InputError it navigates by itself, or waits for its targets; it is simulated elsewhere
std::unique_ptr<Robot> robot_behind(const RobotOptions& o, const RobotModel& model, const World& world,
                                    link::RobotServer::Parameters& parameters) {
  check_physics(o.physics, *o.on);
  if (o.targets) throw InputError("--targets with --on: would only pass targets on; leave one of them out");
  const auto accept = [&](const link::Welcome& robots_end) {
    if (!robots_end.navigates && !robots_end.lock_step) return;
    throw InputError(fmt::format("--on {}: that robot {}: drive it with baton drive", *o.on,
                                 robots_end.navigates ? "navigates by itself" : "waits for its targets"));
  };
  auto remote = std::make_unique<link::RemoteRobot>(
      model, world.name(),
      link::RemoteRobot::Parameters{
          .address = Address::parse(*o.on), .token = token_in(o.on_token), .accept = accept, .answering = kAnswering});
  parameters.on = remote->welcome().on;
  parameters.remote = remote.get();
  return remote;
}

}  // namespace

int robot(const RobotOptions& o) {
  if (o.sim == o.on.has_value())
    throw InputError("robot: either --sim, or --on tcp://HOST:PORT: where a robot follows targets");
  const RobotModel model = robot_in(o.physics, o.robot);
  const World world = World::load(o.world);
  link::RobotServer::Parameters parameters{.listen = Address::parse(o.listen),
                                           .token = token_in(o.token),
                                           .world = world.name(),
                                           .real_time = o.real_time || o.on,
                                           .navigates_in = o.targets ? nullptr : &world,
                                           .log = [](const std::string& text) { spdlog::info("{}", text); }};
  parameters.planning = [&, live = parameters.real_time](Modes modes) { return planner_of(model, world, modes, live); };
  std::unique_ptr<Robot> robot;
  if (o.on) {
    robot = robot_behind(o, model, world, parameters);
  } else {
    if (o.on_token) throw InputError("--on-token goes with --on tcp://HOST:PORT");
    const Posture start = stand(model, world.site("start"), model.profile().stance.com_height);
    robot = std::make_unique<SimulatedRobot>(model, world, start, model.profile().tick.period,
                                             parameters_of(o.physics, model, "sim", o.seed));
  }
  link::RobotServer server(model, *robot, std::move(parameters));
  fmt::print("{} in {} at {}; d and Enter: damp, a and Enter: arm again, Ctrl-C: end\n", model.profile().name,
             world.name(), server.address().text());
  std::fflush(stdout);
  serve_drivers(server);
  return kDone;
}

int damp(const DampOptions& o) {
  link::damp(Address::parse(o.address), token_in(o.token));
  fmt::print("damped: its motors only brake, until it is armed again at the robot's end\n");
  return kDone;
}

}  // namespace baton::app
