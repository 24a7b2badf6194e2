// Latency from a change of the command to the first joint target affected, by the robot's state at the change.
#include "bench/latency.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>

#include "bench/bench.hpp"
#include "bench/parallel.hpp"

namespace baton::bench {
namespace {

constexpr double kBound = 0.15;  ///< limit on the 99th percentile [s]

Row told(const std::string& name, const std::vector<Change>& all, bool (*counts)(const Change&)) {
  Row row{"latency: " + name, {}, "", "ms"};
  std::map<std::string, int> without;
  int beyond = 0;
  for (const Change& change : all) {
    if (!counts(change)) continue;
    if (!change.latency) {
      ++without[change.first_against.value_or("the same motion")];
      continue;
    }
    row.values.push_back(1e3 * *change.latency);
    if (*change.latency > kBound + 1e-9) ++beyond;
  }
  row.remark = fmt::format("p90 {:.0f}, {} above {:.0f}", row.quantile(0.9), beyond, 1e3 * kBound);
  if (!without.empty()) row.remark += fmt::format("; none at all: {}", counted(without));
  return row;
}

}  // namespace

Rows bench_latency(const Options& options) {
  const RobotModel robot = RobotModel::load(options.robot);
  const World world = World::load("flat");
  const bool terminal = isatty(STDERR_FILENO) == 1;
  std::atomic<int> done{0};
  const std::vector<Change> all = for_seeds(options.trials, 1e9, [&](std::uint64_t seed) {
    Change change = change_of_command(robot, world, seed);
    const int n = ++done;
    if (terminal) fmt::print(stderr, "\r{} of {} changes{}", n, options.trials, n == options.trials ? "\r\033[K" : "");
    return change;
  });
  using C = const Change&;
  Rows rows{told("all changes", all, [](C) { return true; })};
  rows.push_back(told("at rest", all, [](C c) { return c.situation == Situation::at_rest; }));
  rows.push_back(told("double support, same part", all,
                      [](C c) { return c.situation == Situation::double_support && !c.switched; }));
  rows.push_back(told("double support, another part", all,
                      [](C c) { return c.situation == Situation::double_support && c.switched; }));
  rows.push_back(told("a foot in the air, same part", all,
                      [](C c) { return c.situation == Situation::foot_in_air && !c.switched; }));
  rows.push_back(told("a foot in the air, another part", all,
                      [](C c) { return c.situation == Situation::foot_in_air && c.switched; }));
  rows.push_back(told("a motion is the first answer", all, [](C c) { return !c.first_against; }));
  rows.push_back(told("a refusal is, or nothing to do", all, [](C c) { return c.first_against.has_value(); }));
  std::map<std::string, int> at_first;
  for (const Change& change : all) {
    if (change.latency && change.first_against) ++at_first[*change.first_against];
  }
  if (!at_first.empty()) rows.back().remark += "; a motion later: " + counted(at_first);

  Row plan{"latency: an answer to the changed command", {}, ""};
  const double lookahead = 1e6 * robot.profile().tick.lookahead * robot.profile().tick.period;
  int late = 0;
  for (const Change& change : all) {
    for (const double us : change.plan_us) {
      plan.values.push_back(us);
      if (us > lookahead) ++late;
    }
  }
  plan.remark =
      fmt::format("CPU; {} ({:.2f} %) take longer than the lookahead, {:.0f} ms: live they would be late", late,
                  100.0 * late / static_cast<double>(std::max<std::size_t>(1, plan.values.size())), 1e-3 * lookahead);
  rows.push_back(std::move(plan));
  return rows;
}

}  // namespace baton::bench
