#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/link_trial.hpp"
#include "baton/proving/tally.hpp"
#include "baton/record/output_file.hpp"

namespace baton::app {
namespace {

using Json = nlohmann::json;

/// Of all trials so far.
struct LinkTotals {
  long tried = 0, fell = 0, restless = 0, motions = 0, stale = 0, drivers = 0;
  std::array<long, kLinkFaults.size()> faults{};
  std::map<std::uint64_t, Json> failures;  ///< by seed

  void add(const LinkTrialResult& result, std::uint64_t seed) {
    ++tried;
    motions += result.motions;
    stale += result.stale;
    drivers += result.drivers;
    for (std::size_t kind = 0; kind < faults.size(); ++kind)
      faults[kind] += result.faults[kind];
    if (result.fall.empty() && result.rests) return;
    result.fall.empty() ? ++restless : ++fell;
    failures[seed] = {{"seed", seed}, {"fall", result.fall}, {"rests", result.rests}, {"log", result.log}};
  }
  [[nodiscard]] Json json() const {
    Json by_kind;
    for (std::size_t kind = 0; kind < kLinkFaults.size(); ++kind)
      by_kind[std::string(kLinkFaults[kind])] = faults[kind];
    Json json{{"tried", tried},           {"fell", fell},
              {"did_not_rest", restless}, {"fall_rate_95", failure_rate_95(fell, tried)},
              {"motions", motions},       {"drivers", drivers},
              {"stale_ticks", stale},     {"faults", by_kind},
              {"failures", Json::array()}};
    for (const auto& [seed, failure] : failures)
      json["failures"].push_back(failure);
    return json;
  }
};

}  // namespace

int soak_link(const SoakOptions& o) {
  if (!o.seeds) throw InputError("soak --link needs --seeds: the number of trials");
  if (o.segments || o.hours || o.resume || o.breaking || o.plot)
    throw InputError("soak --link takes --seeds, not --segments, --hours, --resume, --break or --plot");
  if (o.physics.scenario || o.physics.plant || o.physics.times != 1.0 || o.calibration || faults_of(o.answers).any())
    throw InputError(
        "soak --link is on the plant real, with late answers: leave out --scenario, --plant, --times, --calibration, "
        "--answer-delay and --answer-loss");
  const RobotModel robot = load_robot(o.robot, o.physics.drive);
  const World world = World::load(o.world);
  check_distinct({{"--report", o.report}}, files_read(o.robot, robot, world));
  const link::NavigationOptions navigation{modes_of(o.modes), state_named(o.physics.state)};
  LinkTotals totals;
  std::atomic<long> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    try {
      for (long i = next++; i < *o.seeds && !interrupted; i = next++) {
        const auto seed = static_cast<std::uint64_t>(o.seed + i);
        const LinkTrialResult result = run_link_trial(robot, world, {seed, navigation, o.episode.value_or(10.0)});
        const std::lock_guard lock(mutex);
        totals.add(result, seed);
        if (isatty(STDERR_FILENO) == 1)
          fmt::print(stderr, "\r\x1b[K{} of {}, {} fell", totals.tried, *o.seeds, totals.fell);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      error = std::current_exception();
      next = *o.seeds;  // no others
    }
  };
  std::vector<std::thread> threads;
  for (int job = 0; job < o.jobs; ++job)
    threads.emplace_back(work);
  for (std::thread& thread : threads)
    thread.join();
  if (isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\r\x1b[K");
  if (error) std::rethrow_exception(error);
  if (o.report) write_whole(*o.report, "--report", totals.json().dump(2) + '\n');
  fmt::print(
      "{} connections with faults: {} fell, {} did not come to rest; {} motions, {} drivers, {:.0f} s without a "
      "fresh stick;",
      totals.tried, totals.fell, totals.restless, totals.motions, totals.drivers,
      static_cast<double>(totals.stale) * robot.profile().tick.period);
  for (std::size_t kind = 0; kind < kLinkFaults.size(); ++kind)
    fmt::print(" {} {}", kLinkFaults[kind], totals.faults[kind]);
  fmt::print("\n");
  return totals.fell > 0 ? kFallen : totals.restless > 0 || interrupted ? kFailed : kDone;
}

}  // namespace baton::app
