#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "app/app.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "app/soak.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/episode_pool.hpp"
#include "baton/record/output_file.hpp"

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
  double tilt = 0.0;            ///< largest trunk tilt [deg]
  std::array<double, 4> rms{};  ///< of COM, soles, hands, ZMP [m]; time-weighted sums of squares until `json`
  double estimate = 0.0;        ///< largest error of the trunk's estimated position, relative to distance travelled
  double drift = 0.0;           ///< largest change of COM height from first to last rest [m]
  std::vector<long> seeds;      ///< seeds of episodes that ended by a fall or an exception

  void add(const EpisodeResult& result, long seed, double period);
  [[nodiscard]] double root(std::size_t what) const { return upright > 0.0 ? std::sqrt(rms[what] / upright) : 0.0; }
  [[nodiscard]] Json json(const Scenario& scenario) const;
};

constexpr std::array<const char*, 4> kTracked{"com", "sole", "hand", "zmp"};

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

void print_head() {
  fmt::print("{:11}  {:>9}  {:>6}  {:>8}  {:>5}  {:>7}  {:>5}  {:>24}  {:>8}\n", "scenario", "survived", "95 %",
             "segments", "moved", "way [m]", "tilt", "rms COM/sole/hand/ZMP [mm]", "estimate");
}

void print(const Row& row) {
  const Tally& t = row.tally;
  fmt::print(
      "{:11}  {:>4}/{:<4}  {:5.1f}%  {:8}  {:4.0f}%  {:7.1f}  {:4.1f}\u00b0  {:6.2f} {:5.2f} {:5.2f} {:6.2f}  "
      "{:7.2f}%\n",
      row.name, row.tried - row.fell, row.tried, 100.0 * (1.0 - failure_rate_95(row.fell, row.tried)), t.segments,
      t.given > 0 ? 100.0 * static_cast<double>(t.moved) / static_cast<double>(t.given) : 0.0, t.travel, row.tilt,
      1e3 * row.root(0), 1e3 * row.root(1), 1e3 * row.root(2), 1e3 * row.root(3), 100.0 * row.estimate);
  std::fflush(stdout);
}

}  // namespace

int soak_scenarios(const SoakOptions& o) {
  if (!o.seeds) throw InputError("soak --scenario needs --seeds: the number of episodes");
  if (o.segments || o.hours || o.resume)
    throw InputError("soak --scenario takes --seeds, not --segments, --hours or --resume");
  std::vector<Scenario> chosen;
  if (*o.physics.scenario == "all") {
    chosen = scenarios();
  } else {
    chosen = {scenario_named(*o.physics.scenario)};
  }
  const World world = World::load(o.world);
  const bool terminal = isatty(STDERR_FILENO) == 1;
  Json report = {{"robot", o.robot},
                 {"world", world.name()},
                 {"state", o.physics.state},
                 {"seed", o.seed},
                 {"times", o.physics.times},
                 {"answer_delay_ms", o.answers.delay_ms},
                 {"answer_loss", o.answers.loss}};
  bool fell = false;
  print_head();
  for (const Scenario& scenario : chosen) {
    SoakOptions one = o;
    one.physics.scenario = std::string(scenario.name);
    one.on = "sim";
    const RobotModel robot = robot_in(one.physics, o.robot);
    Trial trial;
    trial.on = Simulation::On::sim;
    trial.modes = modes_of(o.modes);
    trial.state = state_named(o.physics.state);
    trial.seed = static_cast<std::uint64_t>(o.seed);
    trial.seconds = o.episode.value_or(scenario.seconds);
    trial.scenario = &scenario;
    trial.times = o.physics.times;
    trial.answers = faults_of(o.answers);
    const Episodes episodes(robot, world, trial);
    check_distinct({{"--report", o.report}}, files_read(o.robot, robot, world));
    const double period = robot.profile().tick.period;
    Row row;
    row.name = scenario.name;
    {
      EpisodePool pool(episodes, 0, o.jobs);
      while (row.tried < *o.seeds && !interrupted) {
        const std::optional<EpisodeResult> result = pool.wait(std::chrono::milliseconds(200));
        if (!result) continue;
        const long seed = o.seed + row.tried;
        const long before = row.fell;
        row.add(*result, seed, period);
        if (row.fell > before && o.report) write_replay(one, episodes, *result, period, seed);
        if (terminal) fmt::print(stderr, "\r\x1b[K{}: {} of {}, {} fell", row.name, row.tried, *o.seeds, row.fell);
      }
    }
    if (terminal) fmt::print(stderr, "\r\x1b[K");
    print(row);
    if (scenario.driving == Driving::shift) {
      fmt::print("{:11}  COM height changes from first to last rest by at most {:.2f} mm\n", "", 1e3 * row.drift);
    }
    report["scenarios"][row.name] = row.json(scenario);
    fell = fell || row.fell > 0;
    if (o.report) write_whole(*o.report, "--report", report.dump(2) + '\n');
    if (interrupted) break;
  }
  return fell ? kFallen : interrupted ? kFailed : kDone;
}

}  // namespace baton::app
