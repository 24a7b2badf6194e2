#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/robot_recording.hpp"
#include "app/robots_end.hpp"
#include "baton/ik/stand.hpp"
#include "baton/link/hanging.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/model/error.hpp"

namespace baton::app {
namespace {

constexpr double kHangs = 0.15;          ///< height of the soles of a robot that hangs [COM height]
constexpr double kSlack = 0.1;           ///< by which ropes are lowered beyond the stance [COM height]
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
  parameters.settings = remote->welcome().settings;
  if (o.gantry) {
    spdlog::info("hangs: takes its stance");
    parameters.hold = link::take_stance(model, *remote, Calibration::none(model.nv() - 6), [] { return !interrupted; });
    spdlog::info("in its stance: lower it until it stands once a driver has taken over");
  }
  return remote;
}

/// A simulated robot that stands, or hangs with its joints at zero.
struct Simulated {
  std::unique_ptr<SimulatedRobot> robot;
  double drop = 0.0;  ///< by which its gantry has to be lowered until it stands in its stance, the ropes slack [m]
};

Simulated simulated(const RobotOptions& o, const RobotModel& model, const World& world) {
  const double height = model.profile().stance.com_height;
  Posture start = stand(model, world.site("start"), height);
  SimulatedRobot::Parameters parameters = parameters_of(o.physics, model, "sim", o.seed);
  Simulated made;
  if (o.gantry) {
    Kinematics kinematics(model);
    kinematics.set(start.q);
    const auto shoulder = [&] { return kinematics.shoulder(Side::left).z(); };
    const double ground = start.sole.left.p.z();
    const double standing = shoulder();
    for (std::size_t j = 0; j < model.joints().size(); ++j) {
      const Range& range = model.joints()[j].position;
      start.q[7 + static_cast<Eigen::Index>(j)] = std::clamp(0.0, range.lo, range.hi);
    }
    kinematics.set(start.q);
    const double lowest = std::min(kinematics.sole(Side::left).p.z(), kinematics.sole(Side::right).p.z());
    start.q[2] += ground + kHangs * height - lowest;
    kinematics.set(start.q);
    made.drop = shoulder() - standing + kSlack * height;
    parameters.hangs = true;
  }
  made.robot =
      std::make_unique<SimulatedRobot>(model, world, start, model.profile().tick.period, std::move(parameters));
  return made;
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
  if (o.sim) parameters.settings = plant_settings(o.physics, "sim");
  parameters.planning = [&, live = parameters.real_time](Modes modes) { return planner_of(model, world, modes, live); };
  if (o.gantry && o.sim && !o.targets)
    throw InputError("--gantry with --sim: goes with --targets, as a robot that navigates by itself begins standing");
  std::unique_ptr<Robot> behind;
  Simulated sim;
  if (o.on) {
    behind = robot_behind(o, model, world, parameters);
  } else {
    if (o.on_token) throw InputError("--on-token goes with --on tcp://HOST:PORT");
    sim = simulated(o, model, world);
  }
  std::optional<RobotRecording> recording;
  if (o.record) {
    if (o.targets)
      throw InputError("--record with --targets: only what navigates can be recorded, so at the driver's end");
    std::map<std::string, std::string> settings = plant_settings(parameters.settings);
    settings["on"] = parameters.on;
    recording.emplace(o, model, world, *o.record, std::move(settings));
    parameters.began = [&](link::Onboard& onboard, const link::NavigationOptions& navigation) {
      recording->begin(onboard, navigation);
    };
    parameters.ended = [&] { recording->end(); };
    parameters.log = [&](const std::string& text) {
      spdlog::info("{}", text);
      recording->log(text);
    };
  }
  link::RobotServer server(model, o.on ? *behind : *sim.robot, std::move(parameters));
  fmt::print("{} in {} at {}; d and Enter: damp, a and Enter: arm again{}, Ctrl-C: end\n", model.profile().name,
             world.name(), server.address().text(),
             o.gantry && o.sim ? ", l and Enter: lower it, r and Enter: raise it" : "");
  std::fflush(stdout);
  const auto key = [&](const std::string& line) {
    const bool means = o.gantry && o.sim && (line == "l" || line == "r");
    if (means) sim.robot->move_gantry(line == "l" ? -sim.drop : 0.0);
    return means;
  };
  serve_drivers(
      server, [] {}, key);
  return kDone;
}

int damp(const DampOptions& o) {
  link::damp(Address::parse(o.address), token_in(o.token));
  fmt::print("damped: its motors only brake, until it is armed again at the robot's end\n");
  return kDone;
}

}  // namespace baton::app
