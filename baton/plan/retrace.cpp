#include "baton/plan/retrace.hpp"

#include <algorithm>
#include <utility>

#include "baton/ik/stand.hpp"

namespace baton {

namespace {

Trail::Piece piece_of(const Motion& motion) {
  auto points = std::make_shared<std::vector<Trail::Point>>();
  points->reserve(motion.samples.size());
  for (const MotionSample& sample : motion.samples)
    points->push_back({sample.q, sample.com, sample.sole});
  Trail::Piece piece{std::move(points), motion.phases, motion.goal, motion.ticks()};
  piece.goal.arm_path = nullptr;  // the points have what came of it
  return piece;
}

}  // namespace

int Trail::ticks() const {
  int sum = 0;
  for (const Piece& piece : pieces)
    sum += piece.ticks;
  return sum;
}

Trail trail_of(const Posture& start, const Motion& motion) {
  return {start, {piece_of(motion)}};
}

Trail continued(Trail trail, int ticks, const Motion& next) {
  Trail::Piece& replaced = trail.pieces.back();
  replaced.ticks = ticks;
  // Arms that are driven from outside are planned anew ten times a second, each time a second ahead.
  if (replaced.goal.kind == SegmentKind::arms)
    replaced.points =
        std::make_shared<std::vector<Trail::Point>>(replaced.points->begin(), replaced.points->begin() + ticks + 1);
  trail.pieces.push_back(piece_of(next));
  return trail;
}

std::vector<TrailRest> rests_on(const Trail& trail) {
  std::vector<TrailRest> found;
  int passed = 0;
  for (std::size_t k = trail.pieces.size() - 1; k > 0; --k) {
    passed += trail.pieces[k].ticks;
    const Trail::Piece& replaced = trail.pieces[k - 1];
    const ContactPhase& last = replaced.phases.back();
    if (replaced.ticks == replaced.planned()) continue;  // what would have led to its rest is not kept
    const bool settles = replaced.ticks >= replaced.planned() - last.ticks;
    if (settles && last.contact.left && last.contact.right) found.push_back({k - 1, passed});
  }
  return found;
}

Trail trail_to(const Trail& trail, const TrailRest& halt) {
  const auto end = trail.pieces.begin() + static_cast<std::ptrdiff_t>(halt.piece) + 1;
  Trail way{trail.start, {trail.pieces.begin(), end}};
  way.pieces.back().ticks = way.pieces.back().planned();
  return way;
}

Motion reversed(const RobotModel& robot, const Trail& trail) {
  Motion motion;
  motion.period = robot.profile().tick.period;
  motion.retraces = true;
  motion.end = trail.start;
  motion.rest = resting(robot, trail.start);
  Goal& goal = motion.goal;
  goal = trail.pieces.back().goal;
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
  int last = 1;  // the last sample of a replaced motion is the first of the next
  for (auto piece = trail.pieces.rbegin(); piece != trail.pieces.rend(); ++piece) {
    const std::vector<ContactPhase> phases = first_phases(piece->phases, piece->ticks);
    motion.phases.insert(motion.phases.end(), phases.rbegin(), phases.rend());
    for (int k = piece->ticks - 1 + std::exchange(last, 0); k >= 0; --k) {
      const Trail::Point& point = (*piece->points)[static_cast<std::size_t>(k)];
      MotionSample sample;
      sample.q = point.q;
      sample.com = point.com;
      sample.sole = point.sole;
      motion.samples.push_back(std::move(sample));
    }
  }
  set_contacts(motion);
  motion.dq0 = VecX::Zero(robot.nv());
  differentiate(robot, motion);
  for (std::size_t i = 1; i + 1 < motion.samples.size(); ++i) {
    motion.samples[i].dcom = (motion.samples[i + 1].com - motion.samples[i - 1].com) / (2.0 * motion.period);
  }
  return motion;
}

std::vector<ContactPhase> first_phases(const std::vector<ContactPhase>& phases, int ticks) {
  std::vector<ContactPhase> first;
  for (int remaining = ticks; remaining > 0; remaining -= first.back().ticks) {
    first.push_back(phases[first.size()]);
    first.back().ticks = std::min(first.back().ticks, remaining);
  }
  return first;
}

void set_contacts(Motion& motion) {
  auto sample = motion.samples.begin();
  for (const ContactPhase& phase : motion.phases) {
    for (int i = 0; i < phase.ticks; ++i)
      (sample++)->contact = phase.contact;
  }
  motion.samples.back().contact = motion.phases.back().contact;
}

void differentiate(const RobotModel& robot, Motion& motion) {
  const std::size_t ticks = motion.samples.size() - 1;
  std::vector<VecX> steps(ticks + 2, VecX::Zero(robot.nv()));
  steps.front() = motion.dq0;
  for (std::size_t k = 0; k < ticks; ++k)
    difference(robot, steps[k + 1], motion.period, motion.samples[k].q, motion.samples[k + 1].q);
  for (std::size_t k = 0; k <= ticks; ++k) {
    motion.samples[k].dq = 0.5 * (steps[k] + steps[k + 1]);
    motion.samples[k].ddq = (steps[k + 1] - steps[k]) / motion.period;
  }
  if (motion.dq0.isZero(0.0)) motion.samples.front().dq.setZero();
  motion.samples.back().dq.setZero();
}

}  // namespace baton
