#include "baton/plan/retrace.hpp"

#include <algorithm>

#include "baton/model/kinematics.hpp"

namespace baton {

Trail trail_of(const Posture& start, const Motion& motion) {
  Trail trail{start, motion.goal, motion.phases, {}};
  trail.points.reserve(motion.samples.size());
  for (const MotionSample& sample : motion.samples)
    trail.points.push_back({sample.q, sample.com, sample.sole});
  return trail;
}

Motion reversed(const RobotModel& robot, const Trail& trail) {
  Motion motion;
  motion.period = robot.profile().tick.period;
  motion.retraces = true;
  motion.end = trail.start;
  Goal& goal = motion.goal;
  goal = trail.goal;
  goal.sole = trail.start.sole;
  goal.contact = trail.start.contact;
  goal.com = trail.start.com;
  goal.trunk = trail.start.trunk;
  goal.arms = trail.start.q.tail(robot.nv() - 6);
  if (goal.kind == SegmentKind::lift || goal.kind == SegmentKind::lower) {
    goal.kind = goal.kind == SegmentKind::lift ? SegmentKind::lower : SegmentKind::lift;
  }
  for (const Side side : kSides) {
    if (goal.hand[side]) goal.hand[side] = trail.start.hand[side];
  }
  motion.phases.assign(trail.phases.rbegin(), trail.phases.rend());
  for (auto point = trail.points.rbegin(); point != trail.points.rend(); ++point) {
    MotionSample sample;
    sample.q = point->q;
    sample.com = point->com;
    sample.sole = point->sole;
    motion.samples.push_back(std::move(sample));
  }
  // A sample where two phases meet belongs to the later one.
  std::size_t k = 0;
  for (const ContactPhase& phase : motion.phases) {
    for (int i = 0; i < phase.ticks; ++i)
      motion.samples[k++].contact = phase.contact;
  }
  motion.samples.back().contact = motion.phases.back().contact;
  differentiate(robot, VecX::Zero(robot.nv()), motion);
  for (std::size_t i = 1; i + 1 < motion.samples.size(); ++i) {
    motion.samples[i].dcom = (motion.samples[i + 1].com - motion.samples[i - 1].com) / (2.0 * motion.period);
  }
  return motion;
}

void differentiate(const RobotModel& robot, const VecX& dq0, Motion& motion) {
  const std::size_t ticks = motion.samples.size() - 1;
  std::vector<VecX> steps(ticks + 2, VecX::Zero(robot.nv()));
  steps.front() = dq0;
  for (std::size_t k = 0; k < ticks; ++k)
    difference(robot, steps[k + 1], motion.period, motion.samples[k].q, motion.samples[k + 1].q);
  for (std::size_t k = 0; k <= ticks; ++k) {
    motion.samples[k].dq = 0.5 * (steps[k] + steps[k + 1]);
    motion.samples[k].ddq = (steps[k + 1] - steps[k]) / motion.period;
  }
  motion.samples.front().dq = dq0;
  motion.samples.back().dq.setZero();
}

}  // namespace baton
