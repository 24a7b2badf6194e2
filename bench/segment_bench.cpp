// Single committed segments: planned, corrected for the limbs' contribution to the ZMP, realised at every tick and
// verified, with both duration rules. The segments come from random sticks on `ideal`.
#include <fmt/format.h>

#include "baton/run/simulation.hpp"
#include "bench/bench.hpp"
#include "bench/scripts.hpp"

namespace baton::bench {

Rows bench_segment(const Options& /*unused*/) {
  const RobotModel robot = RobotModel::load("mighty");
  const World world = World::load("flat");
  const Limits limits = Limits::normal(robot.profile());
  Rows rows;
  for (const DurationRule rule : {DurationRule::paper, DurationRule::search}) {
    const std::string name = rule == DurationRule::paper ? "paper's rule" : "search";
    Row segment{"plan: a committed segment, " + name, {}, ""};
    Row request{"plan: a request answered by one, " + name, {}, "guide, all its goals, landing, shrinking"};
    Planner planner(robot, world, rule);
    double T = 0.0;
    double tried = 0.0;
    constexpr int kScripts = 4;
    for (std::uint64_t seed = 1; seed <= kScripts; ++seed) {
      Simulation simulation(robot, world, Simulation::On::ideal, {.session = {.modes = {rule, OnLimit::shrink}}});
      Session& session = simulation.session();
      Hooks hooks;
      session.add(hooks);
      hooks.plan = [&](const PlanRecord& record) {
        const auto* planned = std::get_if<PlannedMotion>(&record.answer.outcome);
        if (planned == nullptr) return;
        request.values.push_back(record.plan_us);
        const GuideContext& context = record.request.start.context;
        std::optional<PlanResult> again;
        time(segment, [&] {
          again = planner.plan(record.request.start.posture, planned->motion->goal, context.anchor, limits);
        });
        T += std::get<PlannedMotion>(*again).motion->duration();
        tried += std::get<PlannedMotion>(*again).durations_tried;
      };
      for (const Stretch& stretch : random_script(seed, 30.0)) {
        while (session.t() < stretch.until - 1e-9)
          session.step(stretch.command);
      }
    }
    const auto n = static_cast<double>(segment.values.size());
    segment.remark = fmt::format("mean T {:.2f} s, {:.1f} durations looked at", T / n, tried / n);
    rows.push_back(std::move(segment));
    rows.push_back(std::move(request));
  }
  return rows;
}

}  // namespace baton::bench
