// Whole runs: a navigator tick, a planning request, and physics with control relative to real time.
#include <fmt/format.h>

#include "baton/run/simulation.hpp"
#include "bench/bench.hpp"

namespace baton::bench {

Rows bench_run(const Options& /*unused*/) {
  const RobotModel robot = RobotModel::load("mighty");
  const World world = World::load("room");
  Simulation simulation(robot, world, Simulation::On::sim);
  Session& session = simulation.session();
  Hooks hooks;
  session.add(hooks);
  Row tick{"navigate: a tick", {}, ""};
  Row plan{"plan: a committed segment, verified whole", {}, "guide, durations, ik and verification at every tick"};
  hooks.tick = [&](const TickRecord& record) { tick.values.push_back(record.tick_us); };
  hooks.plan = [&](const PlanRecord& record) {
    if (std::holds_alternative<PlannedMotion>(record.answer.outcome)) plan.values.push_back(record.plan_us);
  };
  const double before = cpu_us();
  const double seconds = 30.0;
  while (session.t() < seconds) {
    Command command;
    const int part = static_cast<int>(session.t() / 6.0);
    command.axes[part % 2] = part < 3 ? 1.0 : -1.0;
    session.step(command);
  }
  Row sim{"sim: a second of physics with control", {(cpu_us() - before) / seconds}, ""};
  sim.remark = fmt::format("{:.0f} x real time", 1e6 / sim.values.front());
  return {tick, plan, sim};
}

}  // namespace baton::bench
