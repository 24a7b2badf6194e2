#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
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
  Json falls = Json::array();

  void add(const LinkTrialResult& result, std::uint64_t seed) {
    ++tried;
    motions += result.motions;
    stale += result.stale;
    drivers += result.drivers;
    for (std::size_t kind = 0; kind < faults.size(); ++kind)
      faults[kind] += result.faults[kind];
    if (result.fall.empty() && result.rests) return;
    result.fall.empty() ? ++restless : ++fell;
    falls.push_back({{"seed", seed}, {"fall", result.fall}, {"rests", result.rests}, {"log", result.log}});
  }
  [[nodiscard]] Json json() const {
    Json by_kind;
    for (std::size_t kind = 0; kind < faults.size(); ++kind)
      by_kind[std::string(kLinkFaults[kind])] = faults[kind];
    return {{"tried", tried},           {"fell", fell},
            {"did_not_rest", restless}, {"fall_rate_95", failure_rate_95(fell, tried)},
            {"motions", motions},       {"drivers", drivers},
            {"stale_ticks", stale},     {"faults", by_kind},
            {"failures", falls}};
  }
};

}  // namespace

int soak_link(const SoakOptions& o) {
  if (!o.seeds) throw InputError("soak --link needs --seeds: the number of trials");
  if (o.segments || o.hours || o.resume || o.breaking || o.plot || o.physics.scenario)
    throw InputError("soak --link takes --seeds, not --scenario, --segments, --hours, --resume, --break or --plot");
  const RobotModel robot = load_robot(o.robot, o.physics.drive);
  const World world = World::load(o.world);
  LinkTotals totals;
  std::atomic<long> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    try {
      for (long i = next++; i < *o.seeds && !interrupted; i = next++) {
        const auto seed = static_cast<std::uint64_t>(o.seed + i);
        const LinkTrialResult result = run_link_trial(robot, world, {seed, o.episode.value_or(10.0)});
        const std::lock_guard lock(mutex);
        totals.add(result, seed);
        if (isatty(STDERR_FILENO) == 1)
          fmt::print(stderr, "\r\x1b[K{} of {}, {} fell", totals.tried, *o.seeds, totals.fell);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      error = std::current_exception();
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
