#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/robots_end.hpp"
#include "baton/bridge/rcss_robot.hpp"
#include "baton/ik/stand.hpp"

namespace baton::app {
namespace {

/// The profile of a robot of the simulator: rcss_k1 for K1.
std::string profile_of_rcss(std::string robot) {
  std::transform(robot.begin(), robot.end(), robot.begin(), [](unsigned char c) { return std::tolower(c); });
  return "rcss_" + robot;
}

}  // namespace

int bridge_rcss(const BridgeRcssOptions& o) {
  const RobotModel model = load_robot(o.profile.value_or(profile_of_rcss(o.robot)), std::nullopt);
  const World world = World::load("flat");
  const auto log = [](const std::string& text) { spdlog::info("{}", text); };
  bridge::RcssRobot robot(model, stand(model, world.site("start"), model.profile().stance.com_height),
                          {.server = Address::parse(o.server), .robot = o.robot, .log = log});
  link::RobotServer server(
      model, robot,
      {.listen = Address::parse(o.listen), .token = token_in(o.token), .on = "sim", .world = world.name(), .log = log});
  robot.probe();
  fmt::print("{} of the simulator {} at {}; d and Enter: damp, a and Enter: arm again, Ctrl-C: end\n", o.robot,
             o.server, server.address().text());
  std::fflush(stdout);
  try {
    serve_drivers(server, [&] {
      if (server.state() == link::RobotServer::State::waiting) robot.leave();
    });
  } catch (const bridge::SimulatorError& error) {
    server.damp(error.what());  // tells the driver why
    throw;
  }
  return kDone;
}

}  // namespace baton::app
