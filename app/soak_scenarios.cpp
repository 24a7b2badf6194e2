#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "app/app.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "app/soak.hpp"
#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/proving/episode_pool.hpp"
#include "baton/record/output_file.hpp"
#include "baton/record/plot.hpp"

namespace baton::app {
namespace {

using Json = nlohmann::json;

/// Totals over the episodes of one scenario.
struct Row {
  std::string name;
  long tried = 0;
  long fell = 0;
  double seconds = 0.0;
  double upright = 0.0;  ///< total time of episodes without a fall [s]
  Tally tally;
  double tilt = 0.0;  ///< largest trunk tilt [deg]
  std::array<double, 5>
      rms{};              ///< of COM, soles, hands, ZMP, estimated COM [m]; time-weighted sums of squares until `json`
  double estimate = 0.0;  ///< largest error of the trunk's estimated position, relative to distance travelled
  double drift = 0.0;     ///< largest change of COM height from first to last rest [m]
  std::vector<long> seeds;  ///< seeds of episodes that ended by a fall or an exception

  void add(const EpisodeResult& result, long seed, double period);
  [[nodiscard]] double root(std::size_t what) const { return upright > 0.0 ? std::sqrt(rms[what] / upright) : 0.0; }
  [[nodiscard]] Json json(const Scenario& scenario) const;
};

constexpr std::array<const char*, 5> kTracked{"com", "sole", "hand", "zmp", "com_estimated"};

void Row::add(const EpisodeResult& result, long seed, double period) {
  ++tried;
  const bool falls = result.summary.at("falls").get<int>() > 0 || result.tally.bad.count("exception") > 0;
  if (falls) {
    ++fell;
    seeds.push_back(seed);
  }
  const double lasted = static_cast<double>(result.ticks) * period;
  seconds += lasted;
  tally.add(result.tally);
  if (falls) return;  // after a fall there is no tracking to measure
  upright += lasted;
  tilt = std::max(tilt, result.summary.at("tilt_deg_max").get<double>());
  const Json& tracking = result.summary.at("tracking");
  for (std::size_t i = 0; i < rms.size(); ++i) {
    const double value = tracking.at(std::string(kTracked[i]) + "_rms_m").get<double>();
    rms[i] += lasted * value * value;
  }
  estimate = std::max(estimate, tracking.at("estimate_share").get<double>());
  const Json& height = result.summary.at("com_height_m");
  drift = std::max(drift, std::abs(height.at("last").get<double>() - height.at("first").get<double>()));
}

Json Row::json(const Scenario& scenario) const {
  Json tracking;
  for (std::size_t i = 0; i < rms.size(); ++i)
    tracking[std::string(kTracked[i]) + "_rms_m"] = root(i);
  tracking["estimate_share"] = estimate;
  return {{"what", scenario.what},      {"tried", tried},
          {"survived", tried - fell},   {"fall_rate_95", failure_rate_95(fell, tried)},
          {"fell_with_seeds", seeds},   {"simulated_s", seconds},
          {"segments", tally.segments}, {"commands", {{"given", tally.given}, {"moved", tally.moved}}},
          {"travel_m", tally.travel},   {"violations", tally.bad},
          {"tilt_deg_max", tilt},       {"com_height_drift_m", drift},
          {"tracking", tracking}};
}

double moved_percent(const Row& row) {
  return row.tally.given > 0 ? 100.0 * static_cast<double>(row.tally.moved) / static_cast<double>(row.tally.given)
                             : 0.0;
}

void print_head() {
  fmt::print("{:13}  {:>9}  {:>6}  {:>8}  {:>5}  {:>7}  {:>5}  {:>24}  {:>8}\n", "scenario", "survived", "95 %",
             "segments", "moved", "way [m]", "tilt", "rms COM/sole/hand/ZMP [mm]", "estimate");
}

void print(const Row& row) {
  const Tally& t = row.tally;
  fmt::print(
      "{:13}  {:>4}/{:<4}  {:5.1f}%  {:8}  {:4.0f}%  {:7.1f}  {:4.1f}\u00b0  {:6.2f} {:5.2f} {:5.2f} {:6.2f}  "
      "{:7.2f}%\n",
      row.name, row.tried - row.fell, row.tried, 100.0 * (1.0 - failure_rate_95(row.fell, row.tried)), t.segments,
      moved_percent(row), t.travel, row.tilt, 1e3 * row.root(0), 1e3 * row.root(1), 1e3 * row.root(2),
      1e3 * row.root(3), 100.0 * row.estimate);
  std::fflush(stdout);
}

/// Runs the episodes of a scenario.
class Rows {
 public:
  /// `world` must outlive this object.
  Rows(const SoakOptions& options, const World& world)
      : options_(options), world_(&world), terminal_(isatty(STDERR_FILENO) == 1) {
    options_.on = "sim";
  }

  /// @param first_fall stop after it; else run all seeds and write a replay of each fall
  [[nodiscard]] Row run(const Scenario& scenario, double times, bool first_fall) {
    options_.physics.scenario = std::string(scenario.name);
    options_.physics.times = times;
    const RobotModel robot = robot_in(options_.physics, options_.robot);
    std::vector<NamedFile> read = files_read(options_.robot, robot, *world_);
    read.push_back({"--calibration", options_.calibration});
    check_distinct({{"--report", options_.report}, {"--plot", options_.plot}}, read);
    Trial trial;
    trial.on = Simulation::On::sim;
    trial.modes = modes_of(options_.modes);
    trial.state = state_named(options_.physics.state);
    trial.seed = static_cast<std::uint64_t>(options_.seed);
    trial.seconds = options_.episode.value_or(scenario.seconds);
    trial.real = is_real(options_.physics, options_.on);
    trial.scenario = &scenario;
    trial.times = times;
    trial.answers = faults_of(options_.answers);
    trial.calibration = calibration_in(options_.calibration, robot, "sim");
    const Episodes episodes(robot, *world_, trial);
    const double period = robot.profile().tick.period;
    Row row;
    row.name = scenario.name;
    EpisodePool pool(episodes, 0, options_.jobs);
    while (row.tried < *options_.seeds && !interrupted && !(first_fall && row.fell > 0)) {
      const std::optional<EpisodeResult> result = pool.wait(std::chrono::milliseconds(200));
      if (!result) continue;
      const long seed = options_.seed + row.tried;
      const long before = row.fell;
      row.add(*result, seed, period);
      if (row.fell > before && options_.report && !first_fall) write_replay(options_, episodes, *result, period, seed);
      if (terminal_)
        fmt::print(stderr, "\r\x1b[K{} x {:.3g}: {} of {}, {} fell", row.name, times, row.tried, *options_.seeds,
                   row.fell);
    }
    if (terminal_) fmt::print(stderr, "\r\x1b[K");
    return row;
  }

 private:
  SoakOptions options_;
  const World* world_;
  bool terminal_;
};

/// How large a scenario may be.
struct Breaking {
  double holds = 0.0;            ///< largest factor tried at which no episode ended in a fall
  double moved = 0.0;            ///< commands that moved there [%]
  std::optional<double> breaks;  ///< smallest factor at which one did; none: not up to `kMost`

  static constexpr double kMost = 64.0;    ///< largest factor tried
  static constexpr double kFinest = 1.08;  ///< ratio of the two at the end
  static constexpr double kLeast = 0.02;   ///< their difference, where nothing else holds
};

/// Doubles the factor until an episode ends in a fall, then bisects.
/// @param at_one the row of factor 1
Breaking breaking_point(const Scenario& scenario, const Row& at_one, Rows& rows) {
  Breaking found;
  const auto note = [&](double times, const Row& row) {
    if (row.fell > 0) {
      found.breaks = times;
    } else {
      found.holds = times;
      found.moved = moved_percent(row);
    }
  };
  note(1.0, at_one);
  while (!found.breaks && found.holds < Breaking::kMost && !interrupted)
    note(2.0 * found.holds, rows.run(scenario, 2.0 * found.holds, true));
  while (found.breaks && *found.breaks > std::max(Breaking::kFinest * found.holds, Breaking::kLeast) && !interrupted) {
    const double between = found.holds > 0.0 ? std::sqrt(found.holds * *found.breaks) : 0.5 * *found.breaks;
    note(between, rows.run(scenario, between, true));
  }
  return found;
}

Json json_of(const Breaking& breaking) {
  return {{"holds", breaking.holds},
          {"moved_percent", breaking.moved},
          {"breaks", breaking.breaks ? Json(*breaking.breaks) : Json()}};
}

/// @param row of factor 1, and its breaking point, as in the report
/// @returns the breaking point
/// @throws InputError it is no such row
Breaking print_breaking(const std::string& name, const JsonReader& row) {
  const JsonReader point = row.at("breaking");
  Breaking breaking{point.at("holds").number(), point.at("moved_percent").number(), std::nullopt};
  if (!point.at("breaks").json().is_null()) breaking.breaks = point.at("breaks").number();
  const double given = row.at("commands").at("given").number();
  const double moved = row.at("commands").at("moved").number();
  fmt::print("{:13}  {:>4}/{:<4}  {:4.0f}%  {:>8}  {:4.0f}%  {:>8}\n", name, row.at("survived").number(),
             row.at("tried").number(), given > 0.0 ? 100.0 * moved / given : 0.0,
             fmt::format("x {:.3g}", breaking.holds), breaking.moved,
             breaking.breaks ? fmt::format("x {:.3g}", *breaking.breaks) : "-");
  std::fflush(stdout);
  return breaking;
}

/// The rows of breaking points that the report has already.
/// @param head settings
/// @throws InputError it is no such report, or one with other settings
Json rows_before(const SoakOptions& o, const Json& head) {
  std::error_code ignored;
  if (!o.resume || !std::filesystem::exists(*o.report, ignored)) return Json::object();
  const std::string place = fmt::format("--resume {}", o.report->string());
  Json old = parse_json(read_input(*o.report, "--resume"), place);
  const JsonReader read(old, place);
  for (const auto& [key, value] : head.items()) {
    if (read.at(key.c_str()).json() != value)
      throw InputError(fmt::format("{}: {} is {} in the file and {} here", place, key, shown(old[key]), value.dump()));
  }
  return old.value("scenarios", Json::object());
}

/// A bar from nothing to what each scenario holds, and on to where it breaks, on a scale of doublings.
void plot_breaking(const std::filesystem::path& file, const std::vector<std::pair<std::string, Breaking>>& all) {
  constexpr double kLowest = -4.0;  ///< of the scale
  const auto doublings = [&](double factor) { return std::max(kLowest, std::log2(factor)); };
  Panel panel;
  panel.title = "How many times as large a disturbance may be before one run ends in a fall";
  panel.x_label = "factor as a power of 2 (0: as described)";
  panel.x_range = Range{kLowest, std::log2(Breaking::kMost) + 0.5};
  panel.y_range = Range{-0.7, static_cast<double>(all.size()) - 0.3};
  panel.height = 18.0 * static_cast<double>(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& [name, breaking] = all[all.size() - 1 - i];  // the first one on top
    const double y = static_cast<double>(i);
    panel.rows.push_back(name);
    panel.areas.push_back(
        band("no fall", {kLowest, y - 0.3}, {doublings(breaking.holds), y + 0.3}, palette::kBlue, 0.8));
    if (breaking.breaks)
      panel.areas.push_back(band("a fall", {doublings(*breaking.breaks), y - 0.3},
                                 {doublings(*breaking.breaks) + 0.1, y + 0.3}, palette::kVermilion, 1.0));
  }
  save_plot(file, std::span(&panel, 1));
}

/// Scenarios by the options.
std::vector<Scenario> chosen_scenarios(const SoakOptions& o) {
  if (*o.physics.scenario != "all") {
    const Scenario& one = scenario_named(*o.physics.scenario);
    check_times(one, o.physics.times);
    if (o.breaking && one.deviate == nullptr)
      throw InputError(fmt::format("--break: the scenario {} has no size that could be scaled", one.name));
    return {one};
  }
  std::vector<Scenario> all;
  for (const Scenario& scenario : scenarios()) {
    if (scenario.deviate != nullptr || (o.physics.times == 1.0 && !o.breaking)) all.push_back(scenario);
  }
  return all;
}

/// Options with the defaults of --break.
SoakOptions completed(SoakOptions o) {
  if (o.breaking) {
    if (o.physics.times != 1.0) throw InputError("--break looks for --times itself: leave it out");
    if (!o.seeds) o.seeds = 20;
    if (!o.episode) o.episode = 30.0;
  }
  if (!o.seeds) throw InputError("soak --scenario needs --seeds: the number of episodes");
  if (o.plot && !o.breaking) throw InputError("--plot goes with --break");
  if (o.segments || o.hours) throw InputError("soak --scenario takes --seeds, not --segments or --hours");
  if (o.resume && !(o.breaking && o.report))
    throw InputError(
        "--resume of scenarios goes with --break and --report: its rows are those that are not done again");
  return o;
}

}  // namespace

int soak_scenarios(const SoakOptions& given) {
  const SoakOptions o = completed(given);
  const std::vector<Scenario> chosen = chosen_scenarios(o);
  const World world = World::load(o.world);
  Json report = {{"robot", o.robot},
                 {"world", world.name()},
                 {"plant", plant_name(o.physics, "sim")},
                 {"state", o.physics.state},
                 {"seed", o.seed},
                 {"times", o.physics.times},
                 {"answer_delay_ms", o.answers.delay_ms},
                 {"answer_loss", o.answers.loss}};
  if (o.breaking) {
    report["duration"] = o.modes.duration;
    report["gait"] = o.modes.gait;
    report["on_limit"] = o.modes.on_limit;
    report["drive"] = o.physics.drive ? Json(*o.physics.drive) : Json();
    report["calibration"] = o.calibration ? Json(o.calibration->string()) : Json();
    report["seeds"] = *o.seeds;
    report["episode_s"] = *o.episode;
  }
  const Json before = rows_before(o, report);
  bool fell = false;
  Rows rows(o, world);
  std::vector<std::pair<std::string, Breaking>> all;
  if (o.breaking) {
    fmt::print("{:13}  {:>9}  {:>5}  {:>8}  {:>5}  {:>8}\n", "scenario", "survived", "moved", "holds", "moved",
               "breaks");
  } else {
    print_head();
  }
  for (const Scenario& scenario : chosen) {
    const std::string name(scenario.name);
    Json& entry = report["scenarios"][name];
    if (before.contains(name)) {
      entry = before.at(name);
    } else {
      const Row row = rows.run(scenario, o.physics.times, false);
      entry = row.json(scenario);
      fell = fell || (!o.breaking && row.fell > 0);
      if (o.breaking) {
        const Breaking breaking = breaking_point(scenario, row, rows);
        if (interrupted) {
          report["scenarios"].erase(name);
          break;
        }
        entry["breaking"] = json_of(breaking);
      } else {
        print(row);
        if (scenario.driving == Driving::shift)
          fmt::print("{:13}  COM height changes from first to last rest by at most {:.2f} mm\n", "", 1e3 * row.drift);
      }
    }
    if (o.breaking) {
      all.emplace_back(name, print_breaking(name, JsonReader(entry, fmt::format("scenario {}", name))));
      if (o.plot) plot_breaking(*o.plot, all);
    }
    if (o.report) write_whole(*o.report, "--report", report.dump(2) + '\n');
    if (interrupted) break;
  }
  if (interrupted && o.breaking && o.report) fmt::print("interrupted; continue with --resume\n");
  return fell ? kFallen : interrupted ? kFailed : kDone;
}

}  // namespace baton::app
