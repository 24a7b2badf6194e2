#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <vector>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/robots_end.hpp"
#include "baton/bridge/rcss_robot.hpp"
#include "baton/ik/stand.hpp"

namespace baton::app {
namespace {

constexpr std::chrono::seconds kLongestPause{2};  ///< after which the simulator is told that the robot is still there

}  // namespace

int bridge_rcss(const BridgeRcssOptions& o) {
  const RobotModel model = load_robot(o.robot, std::nullopt);
  const World world = World::load("flat");
  const auto log = [](const std::string& text) { spdlog::info("{}", text); };
  bridge::RcssRobot robot(model, stand(model, world.site("start"), model.profile().stance.com_height),
                          {.server = Address::parse(o.server), .log = log});
  link::RobotServer server(
      model, robot,
      {.listen = Address::parse(o.listen), .token = token_in(o.token), .on = "sim", .world = world.name(), .log = log});
  robot.join();
  fmt::print("{} of the simulator {} at {}; d and Enter: damp, a and Enter: arm again, Ctrl-C: end\n", robot.name(),
             o.server, server.address().text());
  std::fflush(stdout);
  try {
    long cycles = 0;
    auto since = std::chrono::steady_clock::now();  // the last cycle
    serve_drivers(server, [&] {
      // Standing up takes a second or two: not while the next driver waits for its first measurement.
      if (server.state() == link::RobotServer::State::waiting) robot.reset();
      const auto now = std::chrono::steady_clock::now();
      if (robot.cycles() != std::exchange(cycles, robot.cycles())) since = now;
      if (now - since > kLongestPause) robot.wait(server.state() == link::RobotServer::State::damped);
    });
  } catch (const bridge::SimulatorError& error) {
    server.damp(error.what());  // tells the driver why
    throw;
  }
  return kDone;
}

int bridge(const BridgeOptions& o) {
  // A program of its own beside this one: what it needs, and what can bring it down, stays out of this one.
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (own.parent_path() / ("baton-bridge-" + o.to)).string();
  std::vector<std::string> words{program};
  words.insert(words.end(), o.options.begin(), o.options.end());
  std::vector<char*> arguments;
  for (std::string& word : words)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw std::runtime_error(fmt::format(
      "bridge {}: {}: {}{}", o.to, program, std::strerror(errno),
      errno == ENOENT ? "; it is built where Cyclone DDS is, which scripts/setup installs: make build" : ""));
}

}  // namespace baton::app
