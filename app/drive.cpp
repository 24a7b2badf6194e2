#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/inputs.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "app/view.hpp"
#include "baton/link/engage.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/model/error.hpp"
#include "baton/record/json.hpp"
#include "baton/run/planning_thread.hpp"

namespace baton::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFrame{33};
constexpr double kSettled = 0.5;  ///< time of rest after which a robot has taken its stance, or cannot [s]
const Command kHome{.recall = Recall::home};
constexpr double kNotFollowing = 0.1;       ///< time of rejected targets after which a run ends [s]
constexpr std::chrono::seconds kReload{3};  ///< a page gone for longer has been closed

/// "left foot: refused 3 times in a row; another part may move, and retrace (Backspace, T3, Back) leads out"
void say_what_leads_out(const Stuck& stuck) {
  std::vector<std::string> ways;
  if (stuck.retrace) ways.emplace_back("retrace (Backspace, T3, Back)");
  if (stuck.home) ways.emplace_back("home (H, T4, Start)");
  std::string part(to_string(stuck.part));
  std::replace(part.begin(), part.end(), '_', ' ');
  spdlog::warn("{}: refused {} times in a row; another part may move{}", part, stuck.times,
               ways.empty() ? "" : fmt::format(", and {} leads out", fmt::join(ways, " or ")));
}

/// Shows the fallen robot until all pages are closed or the program is interrupted.
void show_fall(View& view, const Simulation& simulation, const Inputs& inputs, const Refusals& refusals) {
  if (view.pages() == 0) return;
  spdlog::info("the page shows the fall; close the page or press Ctrl-C to end");
  Clock::time_point seen = Clock::now();
  while (!interrupted && Clock::now() - seen < kReload) {
    if (view.pages() > 0) seen = Clock::now();
    view.show(simulation, inputs.status(), refusals);
    std::this_thread::sleep_for(kFrame);
  }
}

/// @throws InputError the robot does not measure what the state is estimated from
void check_sensors(const Measurement& measured, StateSource source, const std::string& on) {
  const auto because = [&](const char* lacks, const char* must) {
    throw InputError(
        fmt::format("--state {}: the robot at {} measures no {}: must be {}", to_string(source), on, lacks, must));
  };
  const auto feels = [&](Side side) { return !measured.sole[side].force.array().isNaN().all(); };
  if (source == StateSource::sensors && !feels(Side::left) && !feels(Side::right))
    because("forces on its soles", "--state torques");
  if (source == StateSource::torques && measured.torque.size() == 0) because("motor torques", "--state sensors");
  if (source == StateSource::perfect && !measured.root) because("pose of its root", "--state sensors or torques");
}

/// The robot at the other end of `--on`, if it is an address.
/// @throws InputError options that only the robot's own end has; it is another robot, or stands elsewhere
std::unique_ptr<link::RemoteRobot> remote_robot(const DriveOptions& o, const RobotModel& robot, const World& world) {
  if (!is_address(o.on)) {
    if (o.token) throw InputError(fmt::format("--token {} goes with --on tcp://HOST:PORT", o.token->string()));
    return nullptr;
  }
  check_physics(o.physics, o.on);
  auto remote = std::make_unique<link::RemoteRobot>(
      robot, world.name(), link::RemoteRobot::Parameters{Address::parse(o.on), token_in(o.token)});
  check_sensors(remote->read(), state_named(o.physics.state), o.on);
  return remote;
}

/// Says whether the robot has come to its stance.
void say_engaged(const Session& session, const Refusals& refusals) {
  if (link::in_stance(session.model(), session.navigator().state().q.tail(session.model().nv() - 6))) {
    spdlog::info("in its stance");
  } else {
    spdlog::warn("does not find to its stance{}: guide it from where it is", refusals.count() > 0 ? ", refused" : "");
  }
}

/// Warns of targets that the robot has rejected since the last call.
void warn_of_rejections(const link::RemoteRobot& robot, long& told) {
  if (robot.rejected() == told) return;
  if (told == 0) spdlog::warn("the robot has rejected a target: {}", robot.rejection());
  told = robot.rejected();
}

/// @param live plan asynchronously, dropping late answers; else synchronously
std::unique_ptr<Planning> planner_of(const RobotModel& robot, const World& world, Modes modes, bool live) {
  if (live) return std::make_unique<PlanningThread>(robot, world, modes);
  return std::make_unique<DirectPlanning>(robot, world, modes);
}

}  // namespace

int drive(const DriveOptions& o) {
  if (o.fast && !o.seconds) throw InputError("--fast needs --seconds: nothing else ends the run");
  const RobotModel robot = robot_in(o.physics, o.robot);
  const World world = World::load(o.world);
  Inputs inputs(o.input, o.fast);
  if (o.input == "page" && (o.headless || o.fast))
    throw InputError("--input page needs the page: leave out --headless and --fast");
  const double period = robot.profile().tick.period;
  std::unique_ptr<link::RemoteRobot> connected = remote_robot(o, robot, world);
  link::RemoteRobot* const remote = connected.get();
  const std::string on = remote != nullptr ? remote->welcome().on : o.on;
  // A robot that waits for its targets waits for the planner, too.
  const bool waits = remote != nullptr ? remote->welcome().lock_step : o.fast;
  const bool paced = !o.fast && (remote == nullptr || waits);  // by our clock
  const std::unique_ptr<Planning> planner = planner_of(robot, world, modes_of(o.modes), !waits);
  FaultyPlanning planning(*planner, faults_of(o.answers), period, static_cast<std::uint64_t>(o.seed));
  Simulation::Parameters parameters{.session = {modes_of(o.modes), state_named(o.physics.state), &planning},
                                    .calibration = calibration_in(o.calibration, robot, on)};
  std::optional<Simulation> given;
  if (remote != nullptr) {
    const Measurement seen =
        parameters.calibration ? without_errors(remote->read(), *parameters.calibration) : remote->read();
    parameters.start = named_in(o.on, [&] { return link::engage(robot, world.site("start"), seen.q); });
    given.emplace(robot, world, std::move(connected), parameters);
  } else {
    parameters.physics = parameters_of(o.physics, robot, o.on, o.seed);
    given.emplace(robot, world, on_named(o.on), parameters);
  }
  Simulation& simulation = *given;
  Session& session = simulation.session();
  bool engaging = remote != nullptr && !link::in_stance(robot, parameters.start->q.tail(robot.nv() - 6));
  std::vector<NamedFile> read = files_read(o.robot, robot, world);
  read.push_back({"--input", inputs.script()});
  read.push_back({"--calibration", o.calibration});
  read.push_back({"--token", o.token});
  check_distinct({{"--report", o.files.report},
                  {"--trace", o.files.trace},
                  {"--save-model", o.files.save_model},
                  {"--record", o.files.record}},
                 read);
  Outputs outputs(simulation, o.files.report, o.files.trace, o.files.save_model);

  if (o.files.record) {
    nlohmann::json head = {{"robot", o.robot},
                           {"world", o.world},
                           {"on", on},
                           {"seed", o.seed},
                           {"duration", o.modes.duration},
                           {"gait", o.modes.gait},
                           {"on_limit", o.modes.on_limit},
                           {"state", o.physics.state},
                           {"drive", std::string(to_string(robot.profile().drive))}};
    if (engaging) head["start"] = vector_json(parameters.start->q);
    outputs.record(session, *o.files.record, head);
  }

  std::optional<View> view;
  if (!o.headless && !o.fast) {
    try {
      view.emplace(simulation, o.port);
    } catch (const InputError& error) {
      throw InputError(fmt::format("--port {}: {}", o.port, error.what()));
    }
    inputs.add_page(view->device());
    fmt::print("page at {}\n", view->url());
    std::fflush(stdout);
  }

  if (remote != nullptr) remote->catch_up();  // time has passed while all was prepared
  Durations used, interval;
  long late = 0;
  const Clock::time_point start = Clock::now();
  double began = 0.0;
  bool stopping = false;
  if (engaging) spdlog::info("takes its stance first");
  int rested = 0;  ///< ticks
  bool stuck = false;
  long rejected = 0;   ///< targets
  std::string broken;  ///< why the robot follows no longer; "": it does
  Refusals refusals;
  while (!o.seconds || session.t() < *o.seconds - 0.5 * period) {
    if (interrupted && !stopping) {
      stopping = true;
      spdlog::info("coming to rest");
    }
    if (stopping && session.resting()) break;
    if (paced) {
      const double now = seconds_since(start);
      if (session.t() > 0.0) interval.add(1e6 * (now - began));
      began = now;
    }
    try {
      if (stopping) {
        session.step(Command{});
      } else if (engaging) {
        session.step(kHome);
        rested = session.resting() ? rested + 1 : 0;
        engaging = rested * period < kSettled;
        if (!engaging) say_engaged(session, refusals);
      } else {
        session.step(inputs);
      }
    } catch (const LinkError& error) {
      broken = error.what();
      break;
    }
    if (remote != nullptr) {
      warn_of_rejections(*remote, rejected);
      if (remote->damped()) broken = fmt::format("the robot was damped: {}", remote->damped_because());
      if (remote->not_followed_for() > kNotFollowing)
        broken = fmt::format("the robot follows no longer: {}", remote->rejection());
      if (!broken.empty()) {
        broken = o.on + ": " + broken;
        break;
      }
    }
    refusals.look(session.navigator());
    if (view) view->show(simulation, inputs.status(), refusals);
    const bool was_stuck = std::exchange(stuck, refusals.stuck().has_value());
    if (stuck && !was_stuck) say_what_leads_out(*refusals.stuck());
    if (session.fallen()) {
      try {
        session.step(Command{});  // the fall is seen in the last row
      } catch (const LinkError& error) {
        spdlog::warn("{}", error.what());
      }
      break;
    }
    if (paced) {
      const double left = session.t() - seconds_since(start);
      used.add(1e6 * (period - left));
      if (left < 0.0) ++late;
      std::this_thread::sleep_for(std::chrono::duration<double>(left));
    }
  }

  nlohmann::json loop = nullptr;
  if (paced) {
    const nlohmann::json spent = used.summary();
    const auto slack = [&](const char* quantile) { return 1e6 * period - spent[quantile].get<double>(); };
    loop = {{"period_us", 1e6 * period},
            {"interval_us", interval.summary()},
            {"slack_us", {{"p50", slack("p50")}, {"p1", slack("p99")}, {"min", slack("max")}}},
            {"late", late},
            {"dropped", session.navigator().dropped()}};
  }
  nlohmann::json extra = {{"loop", std::move(loop)}};
  if (remote != nullptr) extra["link"] = {{"address", o.on}, {"rejected", remote->rejected()}, {"broken", broken}};
  const auto finish = [&] {
    const nlohmann::json summary = outputs.write(world.name(), on, o.seed, seconds_since(start), extra);
    const auto number = [](const nlohmann::json& value, const char* format) {  // unknown without truth
      return value.is_null() ? std::string("?") : fmt::format(fmt::runtime(format), value.get<double>());
    };
    const nlohmann::json& commands = summary["commands"];
    const std::string how_it_ended = session.fallen()             ? "fallen: " + simulation.truth().fall
                                     : !broken.empty()            ? "not followed to its end"
                                     : session.truth() == nullptr ? "on its feet, as far as its sensors tell"
                                                                  : "on its feet";
    fmt::print("{:.1f} s on {} in {}: {} segments, {} of {} commands moved, {} m, {}\n", session.t(), o.on,
               world.name(), summary["segments"]["committed"].get<long>(), number(commands["moved"], "{:.0f}"),
               commands["given"].get<long>(), number(summary["travel_m"], "{:.2f}"), how_it_ended);
    std::fflush(stdout);
  };
  if (!session.fallen()) {
    finish();
    if (broken.empty()) return kDone;
    spdlog::error("{}", broken);
    return kFailed;
  }
  try {
    finish();
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());  // a fall is still shown and decides the exit code
  }
  if (view) show_fall(*view, simulation, inputs, refusals);
  return kFallen;
}

}  // namespace baton::app
