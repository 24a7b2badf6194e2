/// baton-bridge-unitree: a Unitree G1 as the robot's end of the protocol. A process of its own, as DDS, which others on
/// the robot's network can bring down, must not be a part of the program that steers.
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "baton/input/typed_lines.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/link/token.hpp"
#include "baton/model/error.hpp"
#include "bridge/unitree/low_level.hpp"
#include "bridge/unitree/reading.hpp"
#include "bridge/unitree/remote.hpp"

namespace baton::unitree {
namespace {

constexpr double kFirstState = 5.0;  ///< time for the robot's first state [s]
constexpr double kOthersEnd = 5.0;   ///< time for other commands to end, once the factory gait is released [s]
constexpr double kAlone = 1.0;       ///< without any, after which they have ended [s]
constexpr double kLastWords = 0.1;   ///< for which a driver can still hear why the bridge ends [s]
constexpr Socket::Time kTurn{5};  ///< a signal that a thread of DDS has taken interrupts no wait, and is seen after it

std::atomic<bool> interrupted{false};

struct Options {
  std::string interface;
  std::string robot = "g1";
  std::string listen = "127.0.0.1:7447";
  std::optional<std::filesystem::path> token;
  bool observe = false;
};

/// Waits until `done`, for at most that long.
/// @returns whether it is done
template <typename Done>
bool await(LowLevel& low_level, double limit, Done done) {
  const double until = low_level.now() + limit;
  while (!interrupted && low_level.now() < until) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return done();
}

void tell(LowLevel& low_level) {
  for (const std::string& message : low_level.messages())
    spdlog::warn("{}", message);
  if (const std::string why = low_level.broken(); !why.empty()) throw std::runtime_error(why);
}

/// @throws std::runtime_error the robot is not heard, or is no G1 with all its joints
void meet(LowLevel& low_level, const std::string& interface) {
  const auto heard = [&] { return low_level.with_motors([](const Motors& motors) { return motors.heard(); }); };
  const bool there = await(low_level, kFirstState, [&] { return heard().has_value(); });
  tell(low_level);
  if (interrupted) return;
  if (!there)
    throw std::runtime_error(
        fmt::format("no state of a robot on rt/lowstate ({}) for {} s: is it on, and is "
                    "--interface the one that leads to it?",
                    interface.empty() ? "no --interface" : interface, kFirstState));
  const LowState state = heard()->state;
  if (state.mode_machine == 4 || state.mode_machine == 6)
    throw std::runtime_error(fmt::format("this G1 has {} joints (mode_machine {}): must be 29",
                                         state.mode_machine == 4 ? 23 : 27, state.mode_machine));
  spdlog::info("a G1 (mode_machine {})", state.mode_machine);
}

/// @throws std::runtime_error it stays, or somebody else goes on to command the motors
void end_factory_gait(LowLevel& low_level) {
  FactoryGait gait(std::chrono::system_clock::now().time_since_epoch().count());
  bool told = false;
  while (!interrupted && gait.state() == FactoryGait::State::asking) {
    if (const std::optional<FactoryGait::Request> request = gait.next(low_level.now()))
      low_level.network().send(*request);
    while (const std::optional<Network::Answer> answer = low_level.network().answer())
      gait.answer(answer->id, answer->code, answer->data, low_level.now());
    if (!gait.name().empty() && !std::exchange(told, true))
      spdlog::warn("ends the factory gait '{}': the robot gives way", gait.name());
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (interrupted) return;
  if (gait.state() == FactoryGait::State::failed) throw std::runtime_error(gait.why());
  if (!await(low_level, kOthersEnd, [&] { return low_level.alone_for() > kAlone; }) && !interrupted)
    throw std::runtime_error("somebody else commands the motors on rt/lowcmd: must be ended first");
  spdlog::info("no factory gait is active");
}

void obey(const std::string& line, LowLevel& low_level, link::RobotServer& server) {
  const auto done = [](const std::optional<std::string>& why) {
    if (why) spdlog::warn("not done: {}", *why);
    return !why;
  };
  const double now = low_level.now();
  if (line == "d" || line == "damp") {
    low_level.with_motors([](Motors& motors) { motors.damp("by the robot's own key"); });
  } else if (line == "a" || line == "arm") {
    if (done(low_level.with_motors([&](Motors& motors) { return motors.arm(now); }))) server.arm();
  } else if (line == "s" || line == "stance") {
    done(low_level.with_motors([&](Motors& motors) { return motors.pose(now); }));
  } else if (!line.empty()) {
    spdlog::warn("type d (damp: the motors only brake), a (arm again) or s (take the stance), each with Enter");
  }
}

/// Says when others decide about the motors than before.
void say_who_decides(LowLevel& low_level, Motors::State& before) {
  const Motors::State now = low_level.with_motors([](const Motors& motors) { return motors.state(); });
  if (std::exchange(before, now) == now) return;
  switch (now) {
    case Motors::State::braking:
      return spdlog::info("the motors brake");
    case Motors::State::posing:
      return spdlog::info("takes its stance");
    case Motors::State::driven:
      return spdlog::info("the motors follow the driver");
    case Motors::State::damped:
      return;  // the server says why
  }
}

/// Lets both ends know what the other one has decided.
void agree(LowLevel& low_level, link::RobotServer& server) {
  using State = link::RobotServer::State;
  low_level.with_motors([&](Motors& motors) {
    if (server.state() == State::damped) motors.damp("by the network");
    if (server.state() != State::driven) motors.release();
  });
  const auto [damped, because] = low_level.with_motors(
      [](const Motors& motors) { return std::pair(motors.state() == Motors::State::damped, motors.damped_because()); });
  if (damped) server.damp(because);
}

/// Only shows what the robot measures, whoever controls it.
int show(LowLevel& low_level, link::RobotServer& server, const RobotModel& model) {
  fmt::print("{} at {}, for drive --shadow: nothing is commanded; Ctrl-C: end\n", model.profile().name,
             server.address().text());
  std::fflush(stdout);
  while (!interrupted) {
    server.serve(kTurn);
    tell(low_level);
  }
  if (const std::string ignored = low_level.ignored(); !ignored.empty()) spdlog::warn("ignored: {}", ignored);
  return 0;
}

int serve(const Options& o) {
  const RobotModel model = RobotModel::load(o.robot);
  const std::string token = link::token_in(o.token);
  LowLevel low_level(model, o.interface, o.observe ? Network::Speaks::never : Network::Speaks::yes);
  G1 robot(model, low_level);
  link::RobotServer server(
      model, robot,
      {.listen = Address::parse(o.listen),
       .token = token,
       .on = "real",
       .real_time = true,
       .immediate = true,
       .only_observed = o.observe,
       .set_servos =
           [&](const link::Start& start) {
             const double now = low_level.now();
             return low_level.with_motors([&](Motors& motors) { return motors.engage(start.kp, start.kd, now); });
           },
       .log = [](const std::string& text) { spdlog::info("{}", text); }});
  meet(low_level, o.interface);
  if (o.observe) return show(low_level, server, model);
  if (!interrupted) end_factory_gait(low_level);
  if (interrupted) return 0;
  low_level.command();
  if (low_level.with_motors([](const Motors& m) { return !remote_of(m.heard()->state.wireless_remote).on; }))
    spdlog::warn("nothing is heard from the remote: it cannot damp");
  fmt::print("{} at {}; d and Enter: damp, a: arm again, s: take the stance, Ctrl-C: end\n", model.profile().name,
             server.address().text());
  std::fflush(stdout);
  TypedLines keyboard;
  Motors::State state = Motors::State::braking;
  while (!interrupted) {
    server.serve(kTurn);
    tell(low_level);
    agree(low_level, server);
    server.set_fault(low_level.with_motors([](const Motors& motors) { return fault_of(motors.heard()->state); }));
    say_who_decides(low_level, state);
    if (const std::optional<std::string> line = keyboard.next()) obey(*line, low_level, server);
  }
  low_level.with_motors([](Motors& motors) { motors.damp("the bridge ends"); });
  for (const double until = low_level.now() + kLastWords; low_level.now() < until;) {
    agree(low_level, server);
    server.serve(kTurn);
  }
  if (const std::string ignored = low_level.ignored(); !ignored.empty()) spdlog::warn("ignored: {}", ignored);
  return 0;
}

int run(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("baton"));
  spdlog::set_pattern("%^%l%$: %v");
  for (const int ending : {SIGINT, SIGTERM, SIGHUP}) {
    const auto before = std::signal(ending, [](int) { interrupted = true; });
    if (ending == SIGHUP && before == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // keep nohup's setting
  }
  // Neither a job in the background that is typed to, nor a log that nobody reads any more, stops a robot's end.
  std::signal(SIGTTIN, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{
      "Lets baton drive a Unitree G1: the robot's end of the protocol, on the robot's DDS network "
      "(docs/unitree.md)"};
  app.name("baton bridge unitree");
  Options o;
  app.add_option("--interface", o.interface, "Network interface that leads to the robot; default: DDS chooses");
  app.add_option("--robot", o.robot, "Robot, for its joints' limits, its stance and its gains")->capture_default_str();
  app.add_option("--listen", o.listen, "Where it waits for a driver; an address that others can reach needs --token")
      ->capture_default_str();
  app.add_option("--token", o.token, "File with the secret that drivers must know");
  app.add_flag("--observe", o.observe,
               "Whoever controls the robot goes on: only show what it measures, to drive --shadow; no driver is taken");
  try {
    app.parse(argc, argv);
    return serve(o);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    fmt::print(stderr, "baton bridge unitree: {}\n", error.what());
    return 2;
  } catch (const InputError& error) {
    fmt::print(stderr, "baton bridge unitree: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "baton bridge unitree: {}\n", error.what());
    return 1;
  }
}

}  // namespace
}  // namespace baton::unitree

int main(int argc, char** argv) {
  return baton::unitree::run(argc, argv);
}
