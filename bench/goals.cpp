#include "bench/goals.hpp"

#include "baton/ik/stand.hpp"
#include "baton/model/contact.hpp"
#include "bench/draw.hpp"

namespace baton::bench {
namespace {

/// A random posture at rest; none if the joints do not allow it.
std::optional<Posture> random_posture(const RobotModel& robot, const Posture& home, InverseKinematics& ik, Draw& draw) {
  const Profile& profile = robot.profile();
  const Profile::Region& region = profile.region;
  Posture wish = home;
  const Side side = draw.chance(0.5) ? Side::left : Side::right;
  if (draw.chance(0.8)) {  // else keep the feet side by side
    const double yaw = draw.real(-0.5, 0.5) * region.foot_yaw;
    wish.sole[side].p = wish.sole[other(side)].p + Vec3(draw.real(-region.stride, region.stride),
                                                        sign_of(side) * draw.real(region.foot_lateral), 0);
    wish.sole[side].R = rotation_z(yaw);
  }
  if (separation(sole_outline(robot, Side::left, wish.sole.left), sole_outline(robot, Side::right, wish.sole.right)) <
      region.sole_gap) {
    return std::nullopt;
  }
  if (draw.chance(0.3)) {
    wish.contact[side] = false;
    wish.sole[side].p.z() += draw.real(0.3, 1.0) * profile.swing.lift;
  }
  const ConvexPolygon rest =
      support_polygon(robot, wish.sole, wish.contact, home.com, 0.0).inset(profile.margin.stand_on);
  if (rest.empty()) return std::nullopt;
  Vec2 com = wish.contact[side] ? Vec2(0.5 * (wish.sole.left.p + wish.sole.right.p).head<2>())
                                : Vec2(wish.sole[other(side)].p.head<2>());
  if (draw.chance(0.7)) {  // else where motions leave the COM
    do {
      com = {draw.real(-0.2, 0.2), draw.real(-0.2, 0.2)};
    } while (rest.margin(com) < 0.0);
  }
  IkTargets targets;
  targets.sole = wish.sole;
  targets.com = {com.x(), com.y(), draw.real(profile.region.com_height)};
  targets.trunk = rotation_z(wish.heading());
  targets.arms = home.q.tail(robot.nv() - 6);
  VecX q = home.q;
  const IkResult result = ik.solve(targets, home.q, std::numeric_limits<double>::infinity(), q, 100);
  const IkResidual& r = result.residual;
  if (!(std::max({r.sole_position, r.sole_rotation, r.com, r.trunk}) < 1e-4)) return std::nullopt;
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const Range& range = robot.joints()[j].position;
    const double angle = q[7 + static_cast<Eigen::Index>(j)];
    if (std::min(angle - range.lo, range.hi - angle) < profile.margin.joint) return std::nullopt;
  }
  Posture posture = posture_of(robot, q);
  posture.com = targets.com;
  posture.sole = targets.sole;
  posture.trunk = targets.trunk;
  posture.contact = wish.contact;
  return posture;
}

Command random_command(const Posture& from, Draw& draw) {
  Command command;
  command.guide = kParts[static_cast<std::size_t>(draw.below(5))];
  for (const int axis : {0, 1, 5})
    command.axes[axis] = draw.chance(0.3) ? 0.0 : draw.real(-1.0, 1.0);
  if (is_hand(command.guide)) {
    command.axes[2] = draw.real(-1.0, 1.0);
    command.axes.head<3>().normalize();
  }
  for (const Side side : kSides)
    command.lift[side] = draw.chance(from.contact[side] ? 0.4 : 0.5) ? draw.real(0.3, 1.0) : 0.0;
  return command;
}

}  // namespace

std::vector<Task> level_tasks(const RobotModel& robot, const World& world, int count, std::uint64_t seed) {
  Draw draw(seed);
  const Posture home = stand(robot, Pose{}, robot.profile().stance.com_height);
  InverseKinematics ik(robot);
  const Guide guide(robot, world);
  std::vector<Task> tasks;
  while (static_cast<int>(tasks.size()) < count) {
    const std::optional<Posture> from = random_posture(robot, home, ik, draw);
    if (!from) continue;
    const Command command = random_command(*from, draw);
    const Side last_step = draw.chance(0.5) ? Side::left : Side::right;
    const GuideResult result = guide.goals({*from, world.site("start"), last_step, from->sole}, command);
    const auto* goals = std::get_if<std::vector<Goal>>(&result);
    if (goals == nullptr) continue;
    Goal goal = (*goals)[static_cast<std::size_t>(draw.below(static_cast<int>(goals->size())))];
    goal.com.z() = from->com.z();
    constexpr double kSame = 1e-3;  // a COM that hardly moves does not challenge the ZMP [m]
    if (!goal.swing && (goal.com - from->com).norm() < kSame) continue;
    tasks.push_back({*from, std::move(goal)});
  }
  return tasks;
}

}  // namespace baton::bench
