// Planning with the paper's duration correction, before inverse kinematics: 1,000 steps, shifts, lifts and turns of the
// point mass, many of which need several durations. The paper took 300 µs a segment.
#include <fmt/format.h>

#include <random>

#include "baton/ik/stand.hpp"
#include "baton/plan/segment.hpp"
#include "bench/bench.hpp"

namespace baton::bench {

Rows bench_plan(const Options& /*unused*/) {
  const RobotModel robot = RobotModel::load("mighty");
  const Profile& profile = robot.profile();
  const Limits limits = Limits::normal(profile);
  const Posture home = stand(robot, Pose{}, profile.stance.com_height);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Segment> segments;
  while (segments.size() < 1000) {
    Posture from = home;
    Goal goal;
    goal.sole = from.sole;
    goal.trunk = from.trunk;
    goal.arms = from.q.tail(robot.nv() - 6);
    // Anywhere in the stand-on region, so that the weight shift is longer.
    from.com.y() += 0.06 * unit(random);
    from.com.x() += 0.03 * unit(random);
    const Side side = unit(random) > 0 ? Side::left : Side::right;
    const double which = unit(random);
    if (which > -0.6) {
      goal.kind = SegmentKind::step;
      goal.swing = side;
      goal.sole[side].p += Vec3(0.08 * unit(random), sign_of(side) * 0.03 * std::abs(unit(random)), 0);
    } else if (which > -0.8) {
      goal.kind = SegmentKind::lift;
      goal.swing = side;
      goal.contact[side] = false;
      goal.sole[side].p.z() += 0.02;
    }
    goal.com = goal.contact.left && goal.contact.right ? Vec3(0.5 * (goal.sole.left.p + goal.sole.right.p))
                                                       : goal.sole[other(side)].p;
    goal.com.z() = from.com.z();
    Segment segment(robot, from, goal, limits);
    const ComPlan plan = correct_duration(segment.com(), profile.duration.first, profile.duration.step,
                                          profile.duration.max, profile.tick.period);
    if (plan.feasible) segments.push_back(std::move(segment));
  }
  Row row{"plan: COM and duration of a segment", {}, ""};
  int several = 0;
  double T = 0.0;
  for (const Segment& segment : segments) {
    ComPlan plan;
    time(row, [&] {
      plan = correct_duration(segment.com(), profile.duration.first, profile.duration.step, profile.duration.max,
                              profile.tick.period);
    });
    several += plan.tried >= 3 ? 1 : 0;
    T += plan.timing.duration() / static_cast<double>(segments.size());
  }
  row.remark =
      fmt::format("{:.0f} % need three durations or more, mean T {:.2f} s; the paper: 300 us", 0.1 * several, T);
  return {row};
}

}  // namespace baton::bench
