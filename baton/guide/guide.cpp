#include "baton/guide/guide.hpp"

#include <algorithm>
#include <cmath>

#include "baton/guide/rules.hpp"
#include "baton/model/contact.hpp"

namespace baton {

GuideResult Guide::goals(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  for (const Side side : kSides) {
    const bool guided = command.guide == foot(side) && command.recall == Recall::none;
    if (!context.from.contact[side] && !guided) return landings(context, side);
  }
  if (context.step && is_foot(command.guide) && side_of(command.guide) != context.step->side) return std::monostate{};
  if (command.recall == Recall::home) return go_home(context);
  if (is_foot(command.guide)) return guide_foot(context, command);
  return command.guide == Part::trunk ? guide_trunk(context, command) : guide_hand(context, command);
}

std::vector<int> Guide::axes_of(Part part) const {
  if (is_foot(part)) return {0, 1, 5};
  if (is_hand(part) && !robot_->hand_has_attitude(side_of(part))) return {0, 1, 2};
  return {0, 1, 2, 3, 4, 5};
}

Command Guide::shortened(const GuideContext& context, const Command& command, double share) const {
  Command shorter = command;
  shorter.axes *= share;
  if (!is_foot(command.guide)) return shorter;
  const Side side = side_of(command.guide);
  double& lift = shorter.lift[side];
  if (lift < kLeastLift) return shorter;  // a foot that is to land does not stay in the air
  double now = 0.0;
  if (!context.from.contact[side]) {
    const Pose in_world = context.anchor * context.from.sole[side];
    now =
        (in_world.p.z() - world_->highest_under(sole_outline(*robot_, side, in_world))) / robot_->profile().swing.lift;
  }
  lift = std::max(kLeastLift, now + share * (lift - now));
  return shorter;
}

GuideResult Guide::go_home(const GuideContext& context) const {
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  // The initial posture except for the feet.
  Goal upright = stay(context, Part::trunk);
  arms_home(upright);
  const auto stand_on = [&](Goal goal) {
    goal.trunk = rotation_z(mean_yaw(goal.sole));
    goal.com = 0.5 * (goal.sole.left.p + goal.sole.right.p) + Vec3(0, 0, profile.stance.com_height);
    return goal;
  };
  std::vector<Goal> goals;
  for (const Side side : {other(context.last_step), context.last_step}) {
    const Pose& stance = from.sole[other(side)];
    const Mat3 R = rotation_z(yaw_of(stance.R));
    const Vec3 at = stance.p + R * Vec3(0, sign_of(side) * profile.stance.width, 0);
    const bool there = (at - from.sole[side].p).head<2>().norm() < kSamePlace &&
                       std::abs(wrap_angle(yaw_of(R) - yaw_of(from.sole[side].R))) < kSameYaw;
    if (there) continue;
    for (const double yaw : {yaw_of(stance.R), yaw_of(from.sole[side].R)}) {
      const Placement placement = nearest_place(context, side, at.head<2>(), yaw, profile.region.foot_x);
      const double nearer = (at - from.sole[side].p).head<2>().norm() - (at - placement.sole.p).head<2>().norm();
      const double turned = std::abs(wrap_angle(yaw_of(stance.R) - yaw_of(from.sole[side].R))) -
                            std::abs(wrap_angle(yaw_of(stance.R) - yaw_of(placement.sole.R)));
      if (placement.refusal || (nearer < kSamePlace && turned < kSameYaw)) continue;
      Goal goal = upright;
      goal.kind = SegmentKind::step;
      goal.swing = side;
      goal.sole[side] = placement.sole;
      goals.push_back(stand_on(goal));
    }
  }
  const Goal now = stay(context, Part::trunk);
  const Goal home = stand_on(upright);
  const bool there = (home.com - from.com).norm() < kSamePlace &&
                     rotation_error(home.trunk, from.trunk).norm() < kSameYaw &&
                     (home.arms - now.arms).cwiseAbs().maxCoeff() < kSameYaw;
  if (!there) {
    goals.push_back(home);
    for (const double share : {0.5, 0.2}) {  // or part of the way
      Goal nearer = home;
      nearer.com = from.com + share * (home.com - from.com);
      nearer.trunk = interpolate(from.trunk, home.trunk, share);
      nearer.arms = now.arms + share * (home.arms - now.arms);
      goals.push_back(std::move(nearer));
    }
  }
  if (goals.empty()) return std::monostate{};
  return goals;
}

Goal Guide::stay(const GuideContext& context, Part guided) const {
  Goal goal;
  goal.guided = guided;
  goal.sole = context.from.sole;
  goal.contact = context.from.contact;
  goal.place_uncertainty = context.place_uncertainty;
  goal.com = context.from.com;
  goal.trunk = limit_tilt(context.from.trunk, robot_->profile().region.trunk_inclination);
  goal.arms = context.from.q.tail(robot_->nv() - 6);
  return goal;
}

void Guide::arms_home(Goal& goal) const {
  for (const Side side : kSides) {
    for (const int j : robot_->arm(side))
      goal.arms[j] = robot_->joints()[static_cast<std::size_t>(j)].home;
  }
}

Vec3 Guide::com_above(const GuideContext& context, const Goal& goal) const {
  const double height = context.from.com.z() - context.from.support_height();
  Vec3 sum = Vec3::Zero();
  int soles = 0;
  for (const Side side : kSides) {
    if (!goal.contact[side]) continue;
    sum += goal.sole[side].p;
    ++soles;
  }
  return sum / soles + Vec3(0, 0, height);
}

void Guide::add_nominal(const GuideContext& context, Goal goal, std::vector<Goal>& goals) const {
  const double height = context.from.com.z() - context.from.support_height();
  const double asked = goal.com.z();
  const double rise = com_above(context, goal).z() - height + robot_->profile().stance.com_height - asked;
  if (std::abs(rise) > kSamePlace) {
    for (const double share : {0.5, 1.0}) {
      goal.com.z() = asked + share * rise;
      goals.push_back(goal);
    }
  }
  if (tilt_of(goal.trunk) < kSameYaw) return;
  goal.trunk = rotation_z(mean_yaw(goal.sole));
  goals.push_back(std::move(goal));
}

}  // namespace baton
