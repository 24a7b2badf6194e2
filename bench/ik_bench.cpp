// Inverse kinematics on a walk and a reach, as the planner realises them: one solve a tick.
#include <fmt/format.h>

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/plan/segment.hpp"
#include "baton/run/simulation.hpp"
#include "bench/bench.hpp"

namespace baton::bench {

Rows ik_rows(const RobotModel& robot, const std::string& prefix) {
  const World world = World::load("flat");
  Simulation simulation(robot, world, Simulation::On::ideal);
  Session& session = simulation.session();
  Hooks hooks;
  session.add(hooks);
  struct Recorded {
    Posture from;
    VerifiedMotion motion;
  };
  std::vector<Recorded> recorded;
  hooks.plan = [&](const PlanRecord& record) {
    if (const auto* planned = std::get_if<PlannedMotion>(&record.answer.outcome)) {
      recorded.push_back({record.request.start.posture, planned->motion});
    }
  };
  while (session.t() < 20.0) {
    Command command;
    command.guide = session.t() < 14.0 ? Part::trunk : Part::left_hand;
    command.axes[0] = 1.0;
    if (command.guide == Part::left_hand) command.axes[2] = 0.5;
    session.step(command);
  }
  InverseKinematics ik(robot);
  Kinematics kinematics(robot);
  Row walk{prefix + "ik: a solve on a walk", {}, ""};
  Row reach{prefix + "ik: a solve on a reach", {}, ""};
  for (Row* row : {&walk, &reach}) {
    double worst = 0.0;
    for (const Recorded& segment_record : recorded) {
      const Posture& from = segment_record.from;
      const Motion& motion = *segment_record.motion;
      if ((row == &reach) != (motion.goal.guided == Part::left_hand)) continue;
      const Segment segment(robot, from, motion.goal, Limits::normal(robot.profile()), part_rates(kinematics, from));
      Timing timing{motion.period, {0}};
      for (const ContactPhase& phase : motion.phases)
        timing.border.push_back(timing.border.back() + phase.ticks);
      VecX before = from.q;
      integrate(robot, before, from.dq, -motion.period);
      VecX previous = from.q;
      for (int k = 1; k <= motion.ticks(); ++k) {
        const IkTargets targets = segment.targets(motion.com, timing, k * motion.period);
        VecX q = previous;
        q.tail(robot.nv() - 6) += (previous - before).tail(robot.nv() - 6);
        q.head<3>() += (previous - before).head<3>();
        IkResult result;
        time(*row, [&] { result = ik.solve(targets, previous, motion.period, q, 3); });
        worst = std::max({worst, result.residual.com, result.residual.sole_position});
        before = previous;
        previous = q;
      }
    }
    row->remark = fmt::format("worst residual of feet and COM {:.1e} m", worst);
  }
  return {walk, reach};
}

Rows bench_ik(const Options& /*unused*/) {
  return ik_rows(RobotModel::load("mighty"), "");
}

}  // namespace baton::bench
