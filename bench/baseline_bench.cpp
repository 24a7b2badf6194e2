// Velocity tracking and baton on the same random sticks: which fails, after how long, and why.
#include <fmt/format.h>

#include "baton/ik/stand.hpp"
#include "baton/run/simulation.hpp"
#include "bench/bench.hpp"
#include "bench/judge.hpp"
#include "bench/parallel.hpp"
#include "bench/scripts.hpp"
#include "bench/velocity_tracking.hpp"

namespace baton::bench {
namespace {

constexpr double kSeconds = 30.0;   ///< length of a script [s]
constexpr double kPatience = 60.0;  ///< time limit for our runs [s]

struct Bankruptcy {
  double t;
  Cause cause;
};
using Verdict = std::optional<Bankruptcy>;

Verdict run_tracking(const RobotModel& robot, const Posture& start, VelocityTracking::Care care, std::uint64_t seed) {
  VelocityTracking tracking(robot, start, care);
  Judge judge(robot);
  double t = 0.0;
  for (const Stretch& stretch : random_script(seed, kSeconds)) {
    for (; t < stretch.until - 1e-9; t += robot.profile().tick.period) {
      tracking.tick(stretch.command);
      const IkTargets& targets = tracking.targets();
      const std::optional<Cause> cause = judge.see(tracking.q(), targets.sole, targets.com, tracking.contact());
      if (cause) return Bankruptcy{t, *cause};
    }
  }
  return std::nullopt;
}

Verdict run_baton(const RobotModel& robot, const World& world, std::uint64_t seed) {
  Simulation simulation(robot, world, Simulation::On::ideal);
  Session& session = simulation.session();
  Hooks hooks;
  session.add(hooks);
  Judge judge(robot);
  Verdict verdict;
  hooks.tick = [&](const TickRecord& record) {
    const MotionSample& sample = record.navigator.sample();
    const Pose& anchor = record.navigator.anchor();
    const std::optional<Cause> cause = judge.see(
        record.truth->q, {anchor * sample.sole.left, anchor * sample.sole.right}, anchor * sample.com, sample.contact);
    if (cause && !verdict) verdict = Bankruptcy{record.t, *cause};
  };
  for (const Stretch& stretch : random_script(seed, kSeconds)) {
    while (session.t() < stretch.until - 1e-9 && !verdict)
      session.step(stretch.command);
  }
  return verdict;
}

Row told(const std::string& name, const std::vector<Verdict>& all) {
  Row row{"failed: " + name, {}, "", "s"};
  std::array<int, kCauses> causes{};
  for (const Verdict& verdict : all) {
    if (!verdict) continue;
    row.values.push_back(verdict->t);
    ++causes[static_cast<std::size_t>(verdict->cause)];
  }
  row.remark = fmt::format("{} of {} scripts of {} s", row.values.size(), all.size(), kSeconds);
  if (row.values.empty()) return row;
  row.remark += fmt::format(", a quarter by {:.1f} s, three by {:.1f} s:", row.quantile(0.25), row.quantile(0.75));
  for (std::size_t i = 0; i < kCauses; ++i) {
    if (causes[i] > 0) row.remark += fmt::format(" {} {}", causes[i], to_string(static_cast<Cause>(i)));
  }
  return row;
}

}  // namespace

Rows bench_baseline(const Options& options) {
  const RobotModel robot = RobotModel::load("mighty");
  const World world = World::load("flat");
  const Posture start = stand(robot, world.site("start"), robot.profile().stance.com_height);
  const int count = options.scripts > 0 ? options.scripts : 1000;
  const double patience = options.scripts > 0 ? 1e9 : kPatience;
  const auto tracking = [&](VelocityTracking::Care care) {
    return for_seeds(count, 1e9, [&](std::uint64_t seed) { return run_tracking(robot, start, care, seed); });
  };
  return {told("the stick's velocity tracked", tracking(VelocityTracking::Care::none)),
          told("the same, within regions", tracking(VelocityTracking::Care::regions)),
          told("baton", for_seeds(count, patience, [&](std::uint64_t seed) { return run_baton(robot, world, seed); }))};
}

}  // namespace baton::bench
