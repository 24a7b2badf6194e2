#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "app/soak.hpp"
#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/proving/episode_pool.hpp"
#include "baton/record/output_file.hpp"

namespace baton::app {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

constexpr long kEnough = 1000;  ///< failures after which the soak ends

/// The report of a soak: settings, totals, and state to resume from.
class SoakReport {
 public:
  SoakReport(const SoakOptions& o, const RobotModel& robot, const World& world)
      : file_(*o.report),
        head_({{"soak", 2},
               {"robot", robot.profile().name},
               {"world", world.name()},
               {"on", o.on},
               {"duration", o.modes.duration},
               {"gait", o.modes.gait},
               {"on_limit", o.modes.on_limit},
               {"seed", o.seed},
               {"state", o.physics.state},
               {"plant", plant_name(o.physics, o.on)},
               {"calibration", o.calibration ? Json(o.calibration->string()) : Json()},
               {"drive", std::string(to_string(robot.profile().drive))},
               {"arms_driven", o.arms},
               {"answer_delay_ms", o.answers.delay_ms},
               {"answer_loss", o.answers.loss},
               {"episode_s", o.episode.value_or(Trial{}.seconds)}}),
        period_(robot.profile().tick.period) {}

  /// Resumes from the file, if it exists.
  /// @throws InputError the file is not a soak report, or one of another soak
  void resume() {
    std::error_code ignored;
    if (!std::filesystem::exists(file_, ignored)) return;
    const std::string place = fmt::format("--resume {}: not the report of a soak", file_.string());
    const Json old = parse_json(read_input(file_, "--resume"), place);
    const JsonReader read(old, place);
    for (const auto& [key, value] : head_.items()) {
      if (read.at(key.c_str()).json() == value) continue;
      throw InputError(fmt::format("--resume {}: {} is {} in the file and {} here", file_.string(), key,
                                   shown(old[key]), value.dump()));
    }
    tally = Tally::from_json(read);
    wall_before_ = read.at("wall").at("seconds").number();
  }

  void write(double wall, int jobs) const {
    Json json = head_;
    json.update(tally.json());
    json["simulated_s"] = static_cast<double>(tally.ticks) * period_;
    json["deflected_share"] =
        tally.ticks > 0 ? static_cast<double>(tally.deflected) / static_cast<double>(tally.ticks) : 0.0;
    json["failure_rate_95"] = failure_rate_95(tally.failures, tally.segments);
    json["wall"] = {{"seconds", wall_before_ + wall}, {"jobs", jobs}};
    write_whole(file_, "--report", json.dump(2) + '\n');
  }

  [[nodiscard]] double hours() const { return static_cast<double>(tally.ticks) * period_ / 3600.0; }

  Tally tally;

 private:
  std::filesystem::path file_;
  Json head_;
  double period_;
  double wall_before_ = 0.0;
};

/// Prints progress to standard error from time to time.
class Progress {
 public:
  explicit Progress(const Tally& before) : segments_(before.segments) {}

  void show(const Tally& tally, double done) {
    const bool terminal = isatty(STDERR_FILENO) == 1;
    const double now = seconds_since(start_);
    if (now - shown_ < (terminal ? 0.5 : 10.0)) return;
    shown_ = now;
    if (first_ < 0.0) first_ = done;
    const double rate = static_cast<double>(tally.segments - segments_) / now;
    const double left = done > first_ ? (1.0 - done) / (done - first_) * now : 0.0;
    fmt::print(stderr, "{}{} episodes, {} segments, {} failures, {:.1f} segments/s, {}{}", terminal ? "\r\x1b[K" : "",
               tally.episodes, tally.segments, tally.failures, rate,
               left > 0.0 ? fmt::format("{:.0f} min left", std::ceil(left / 60.0)) : "time left unknown",
               terminal ? "" : "\n");
    std::fflush(stderr);
    drawn_ = terminal;
  }
  void clear() {
    if (drawn_) fmt::print(stderr, "\r\x1b[K");
    drawn_ = false;
  }
  [[nodiscard]] double seconds() const { return seconds_since(start_); }

 private:
  long segments_;
  Clock::time_point start_ = Clock::now();
  double shown_ = 0.0;
  double first_ = -1.0;
  bool drawn_ = false;
};

}  // namespace

void write_replay(const SoakOptions& o, const Episodes& episodes, const EpisodeResult& result, double period,
                  long seed) {
  const Tally::Failure& failure = result.tally.listed.front();
  const std::string file = fmt::format("{}.{}{}-{}.jsonl", o.report->string(),
                                       o.physics.scenario ? *o.physics.scenario + "-" : "", o.seed, failure.episode);
  write_whole(file, "--report", episodes.script(failure.episode, result));
  fmt::print("episode {}: {} at {:.3f} s: {:.6g}, limit {:.6g}{}{}\n", failure.episode, failure.kind, failure.t,
             failure.value, failure.limit, failure.where.empty() ? "" : ": ", failure.where);
  std::string physics = fmt::format(" --state {}", o.physics.state);
  if (o.on == "sim") physics += fmt::format(" --plant {}", plant_name(o.physics, o.on));
  if (o.physics.drive) physics += fmt::format(" --drive {}", *o.physics.drive);
  if (o.physics.scenario) physics += fmt::format(" --scenario {} --times {}", *o.physics.scenario, o.physics.times);
  if (o.calibration) physics += fmt::format(" --calibration {}", o.calibration->string());
  if (o.answers.delay_ms > 0.0) physics += fmt::format(" --answer-delay {}", o.answers.delay_ms);
  if (o.answers.loss > 0.0) physics += fmt::format(" --answer-loss {}", o.answers.loss);
  if (o.physics.scenario || is_real(o.physics, o.on) || faults_of(o.answers).any())
    physics += fmt::format(" --seed {}", seed);
  fmt::print(
      "  baton drive --robot {} --world {} --on {}{} --duration {} --gait {} --on-limit {} --input script:{} --fast "
      "--seconds {:.3f}\n",
      o.robot, o.world, o.on, physics, o.modes.duration, o.modes.gait, o.modes.on_limit, file,
      static_cast<double>(result.ticks) * period);
  std::fflush(stdout);
}

int soak(const SoakOptions& o) {
  if (!o.report) throw InputError("soak needs --report: the file for the result");
  if (o.seeds) throw InputError("--seeds goes with --scenario");
  if (o.breaking || o.plot) throw InputError("--break and --plot go with --scenario");
  check_physics(o.physics, o.on);
  if (o.segments.has_value() == o.hours.has_value()) throw InputError("soak needs either --segments or --hours");
  const RobotModel robot = load_robot(o.robot, o.physics.drive);
  const World world = World::load(o.world);
  Trial trial;
  trial.on = on_named(o.on);
  trial.modes = modes_of(o.modes);
  trial.state = state_named(o.physics.state);
  trial.seed = static_cast<std::uint64_t>(o.seed);
  trial.seconds = o.episode.value_or(trial.seconds);
  trial.answers = faults_of(o.answers);
  trial.arms = o.arms;
  trial.real = is_real(o.physics, o.on);
  trial.calibration = calibration_in(o.calibration, robot, o.on);
  const Episodes episodes(robot, world, trial);
  std::vector<NamedFile> read = files_read(o.robot, robot, world);
  read.push_back({"--calibration", o.calibration});
  check_distinct({{"--report", o.report}}, read);
  SoakReport report(o, robot, world);
  if (o.resume) report.resume();
  const Tally& tally = report.tally;
  const auto done = [&] {
    if (tally.failures >= kEnough) return 1.0;
    return o.segments ? static_cast<double>(tally.segments) / static_cast<double>(*o.segments)
                      : report.hours() / *o.hours;
  };

  Progress progress(tally);
  report.write(0.0, o.jobs);  // fail before the work if it cannot be written
  double written = 0.0;
  if (done() < 1.0) {
    EpisodePool pool(episodes, tally.episodes, o.jobs);
    while (done() < 1.0 && !interrupted) {
      if (const std::optional<EpisodeResult> result = pool.wait(std::chrono::milliseconds(200))) {
        const bool listed = tally.listed.size() < Tally::kListed;
        report.tally.add(result->tally);
        if (listed && result->tally.failures > 0) {
          progress.clear();
          write_replay(o, episodes, *result, robot.profile().tick.period,
                       o.seed + result->tally.listed.front().episode);
        }
      }
      progress.show(tally, done());
      if (progress.seconds() - written < 10.0) continue;
      written = progress.seconds();
      report.write(written, o.jobs);
    }
  }
  progress.clear();
  report.write(progress.seconds(), o.jobs);
  if (tally.failures >= kEnough) fmt::print("enough failures\n");
  if (interrupted) fmt::print("interrupted; continue with --resume\n");
  if (o.arms && tally.arms.driven > 0)
    fmt::print(
        "arms that the stick does not guide: all joints within 0.05 rad of their targets for {:.1f} % of the time\n",
        100.0 * static_cast<double>(tally.arms.on_target) / static_cast<double>(tally.arms.driven));
  const Tally::Retrace& back = tally.retrace;
  fmt::print(
      "{} violations in {} segments: failure rate below {:.2g} with 95 % confidence; "
      "{} of {} motions retraced, {:.2g} m and {:.2g} rad off at most\n",
      tally.failures, tally.segments, failure_rate_95(tally.failures, tally.segments), back.arrived, back.tried,
      back.worst_m, back.worst_rad);
  return tally.failures == 0 && !interrupted ? kDone : kFailed;
}

}  // namespace baton::app
