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
#include "app/remote_end.hpp"
#include "app/view.hpp"
#include "baton/input/arm_script.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/record/json.hpp"
#include "baton/run/condition_log.hpp"

namespace baton::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFrame{33};
const Command kHome{.recall = Recall::home};
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

void log_arms(const Navigator& navigator, double t) {
  if (find_event<ArmsRefused>(navigator.events()) == nullptr || navigator.arms_refusal() == nullptr) return;
  const Refusal& why = *navigator.arms_refusal();
  spdlog::info("{:.2f} s: the arms cannot follow their targets, or only in part: {} ({} {:.4g}, limit {:.4g})", t,
               info(why.reason).text, place(why), why.value, why.limit);
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

}  // namespace

int drive(const DriveOptions& o) {
  if (o.shadow) return drive_in_shadow(o);
  if (o.fast && !o.seconds) throw InputError("--fast needs --seconds: nothing else ends the run");
  const RobotModel robot = robot_in(o.physics, o.robot);
  const World world = World::load(o.world);
  Inputs inputs(o.input, o.fast);
  if (o.input == "page" && (o.headless || o.fast))
    throw InputError("--input page needs the page: leave out --headless and --fast");
  std::optional<ArmScript> arms;
  std::optional<std::filesystem::path> arms_file;
  if (o.arms) {
    arms_file = script_in(*o.arms);
    if (!arms_file) throw InputError(fmt::format("--arms {}: must be script:FILE", *o.arms));
    arms = ArmScript::load(*arms_file, robot);
  }
  const double period = robot.profile().tick.period;
  if (o.token && !is_address(o.on))
    throw InputError(fmt::format("--token {} goes with --on tcp://HOST:PORT", o.token->string()));
  if (o.gantry && !is_address(o.on)) throw InputError("--gantry goes with --on tcp://HOST:PORT");
  std::optional<RemoteEnd> remote;
  if (is_address(o.on)) remote.emplace(o, robot, world);
  const std::string on = remote ? remote->welcome().on : o.on;
  // A robot that waits for its targets waits for the planner, too.
  const bool waits = remote ? remote->welcome().lock_step : o.fast;
  const bool paced = !o.fast && (!remote || waits);  // by our clock
  std::unique_ptr<Planning> planner = planner_of(robot, world, modes_of(o.modes), !waits);
  if (remote) planner = remote->planning(std::move(planner));
  FaultyPlanning planning(*planner, faults_of(o.answers), period, static_cast<std::uint64_t>(o.seed));
  Simulation::Parameters parameters{.session = {.modes = modes_of(o.modes),
                                                .source = state_named(o.physics.state),
                                                .planning = &planning,
                                                .hangs = o.gantry},
                                    .calibration = calibration_in(o.calibration, robot, on)};
  std::optional<Simulation> given;
  if (remote) {
    parameters.start = remote->start(world, parameters.calibration);
    given.emplace(robot, world, remote->robot(), parameters);
  } else {
    parameters.physics = parameters_of(o.physics, robot, o.on, o.seed);
    given.emplace(robot, world, on_named(o.on), parameters);
  }
  Simulation& simulation = *given;
  Session& session = simulation.session();
  const auto engaging = [&] { return remote && remote->engaging(); };
  std::vector<NamedFile> read = files_read(o.robot, robot, world);
  read.push_back({"--input", inputs.script()});
  read.push_back({"--arms", arms_file});
  read.push_back({"--calibration", o.calibration});
  read.push_back({"--token", o.token});
  check_distinct({{"--report", o.files.report},
                  {"--trace", o.files.trace},
                  {"--save-model", o.files.save_model},
                  {"--record", o.files.record}},
                 read);
  Outputs outputs(simulation, o.files.report, o.files.trace, o.files.save_model);
  ConditionLog condition(robot);
  session.add(condition);

  if (o.files.record) {
    nlohmann::json head =
        recording_head(o.robot, o.world, o.seed, modes_of(o.modes), state_named(o.physics.state), robot);
    head["on"] = on;
    head.update(nlohmann::json(remote ? remote->settings() : plant_settings(o.physics, on)));
    if (o.calibration) head["calibration_sum"] = checksum(read_input(*o.calibration, "--calibration"));
    if (o.gantry) head["hangs"] = true;
    if (remote && !remote->starts_in_stance()) head["start"] = vector_json(parameters.start->q);
    outputs.record(session, *o.files.record, head, !o.fast, parameters.physics.plant.pushes);
  }

  std::optional<View> view;
  if (!o.headless && !o.fast) {
    try {
      view.emplace(simulation, o.port, remote.has_value());
    } catch (const InputError& error) {
      throw InputError(fmt::format("--port {}: {}", o.port, error.what()));
    }
    inputs.add_page(view->device());
    fmt::print("page at {}\n", view->url());
    std::fflush(stdout);
  }

  const auto damp_if_asked = [&] {
    if (view && remote && view->damp_asked()) remote->damp("by the page");
  };
  if (remote) {
    remote->meanwhile(damp_if_asked);
    remote->begin(parameters.calibration, [&] {
      damp_if_asked();
      return !interrupted;
    });
  }
  Durations used, interval;
  long late = 0;
  const Clock::time_point start = Clock::now();
  double began = 0.0;
  bool stopping = false;
  bool stuck = false;
  /// @returns whether the robot still follows
  const auto step = [&](const std::function<Command()>& stick) {
    if (!remote) {
      session.step(stick());
      for (const ConditionLog::Line& line : condition.take())
        spdlog::log(line.warning ? spdlog::level::warn : spdlog::level::info, "{:.2f} s: {}", line.t, line.text);
      return true;
    }
    const bool follows = remote->step(session, stick);
    for (const ConditionLog::Line& line : condition.take())
      remote->note(line.warning, line.what, line.text);
    for (const LinkNote& note : remote->notes())
      outputs.note(note.what, note.text);
    return follows;
  };
  const auto stick = [&] {
    if (stopping) return Command{};
    return engaging() ? kHome : inputs.decide(session.view());
  };
  const auto drive_arms = [&](const ArmTargets& targets) {
    remote ? remote->drive_arms(session, targets) : session.drive_arms(targets);
  };
  Refusals refusals;
  while (!o.seconds || session.t() < *o.seconds - 0.5 * period) {
    if (interrupted && !stopping) {
      stopping = true;
      spdlog::info("coming to rest");
      if (arms) drive_arms(released_arms(robot));
    }
    if (stopping && session.resting()) break;
    if (paced) {
      const double now = seconds_since(start);
      if (session.t() > 0.0) interval.add(1e6 * (now - began));
      began = now;
    }
    while (arms && !stopping && !engaging()) {
      const ArmTargets* targets = arms->next(session.t());
      if (targets == nullptr) break;
      drive_arms(*targets);
    }
    if (!step(stick)) break;
    damp_if_asked();
    refusals.look(session.navigator());
    log_arms(session.navigator(), session.t());
    if (view) view->show(simulation, inputs.status(), refusals, remote ? remote->notice() : "");
    const bool was_stuck = std::exchange(stuck, refusals.stuck().has_value());
    if (stuck && !was_stuck) say_what_leads_out(*refusals.stuck());
    if (session.fallen()) {
      if (!step([] { return Command{}; })) spdlog::warn("{}", remote->broken());  // the fall is seen in the last row
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
  if (remote) extra["link"] = remote->json();
  const std::string broken = remote ? remote->broken() : "";
  const Guard guard = session.navigator().guard();
  const bool lies = session.truth() == nullptr && guard == Guard::fallen && broken.empty();
  const auto finish = [&] {
    const nlohmann::json summary = outputs.write(world.name(), on, o.seed, seconds_since(start), extra);
    const auto number = [](const nlohmann::json& value, const char* format) {  // unknown without truth
      return value.is_null() ? std::string("?") : fmt::format(fmt::runtime(format), value.get<double>());
    };
    const nlohmann::json& commands = summary["commands"];
    const std::string how_it_ended = session.fallen()             ? "fallen: " + simulation.truth().fall
                                     : !broken.empty()            ? "not followed to its end"
                                     : lies                       ? "fallen, by its sensors"
                                     : guard == Guard::lifted     ? "lifted, by its sensors"
                                     : guard == Guard::stood_up   ? "stood up after a fall, its motors without torque"
                                     : session.truth() == nullptr ? "on its feet, as far as its sensors tell"
                                                                  : "on its feet";
    const bool recorded = !summary.contains("recording") || summary["recording"]["complete"].get<bool>();
    std::string rejected;
    for (const auto& [sensor, count] : summary["sensors"].items()) {
      if (count["lost"] > 0)
        rejected += fmt::format("; {} rejected for {:.1f} s", sensor, period * count["rejected_ticks"].get<double>());
    }
    fmt::print("{:.1f} s on {} in {}: {} segments, {} of {} commands moved, {} m, {}{}{}\n", session.t(), o.on,
               world.name(), summary["segments"]["committed"].get<long>(), number(commands["moved"], "{:.0f}"),
               commands["given"].get<long>(), number(summary["travel_m"], "{:.2f}"), how_it_ended, rejected,
               recorded ? "" : "; the recording is not complete");
    std::fflush(stdout);
  };
  if (!session.fallen() && !lies) {
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
  if (view && session.fallen()) show_fall(*view, simulation, inputs, refusals);
  return kFallen;
}

}  // namespace baton::app
