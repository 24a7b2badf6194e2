#include "baton/guide/rules.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kLeastStep = 0.5;  ///< least progress of a step to another foothold, share of the requested distance
constexpr double kLeastApproach = 0.1;  ///< least progress of a step of the other foot, share of the requested distance
constexpr double kLowestLift = 0.25;    ///< least lift of a foot in the air, share of the swing clearance

}  // namespace

GuideResult Guide::guide_foot(const GuideContext& context, const Command& command) const {
  const Side side = side_of(command.guide);
  const Posture& from = context.from;
  const auto [move, yaw, lift] = foot_wish(context, command);
  const bool deflected = command.axes[0] != 0.0 || command.axes[1] != 0.0 || command.axes[5] != 0.0;
  const Vec2 at = from.sole[side].p.head<2>() + move;
  const Placement placement = place(context, side, at, yaw, lift, robot_->profile().region.foot_x, {}, true);
  const bool up = !from.contact[side];
  const bool rises = up && std::abs(placement.sole.p.z() - from.sole[side].p.z()) > kSamePlace;
  if (!deflected && lift == 0.0 && !up) return std::monostate{};
  if (!deflected && lift > 0.0 && up && !rises) return std::monostate{};
  // The same landings as were verified before the foot was lifted: `Strategy::no_landing`.
  if (up && lift == 0.0 && !deflected) return landings(context, side);
  if (placement.refusal) return *placement.refusal;
  return foot_goals(context, side, placement.sole, lift == 0.0);
}

Guide::FootWish Guide::foot_wish(const GuideContext& context, const Command& command) const {
  const Profile& profile = robot_->profile();
  const Side side = side_of(command.guide);
  const double throttle = command.lift[side] < kLeastLift ? 0.0 : command.lift[side];
  // A foot just above the ground would scrape as soon as it lags behind its plan.
  const double lift =
      throttle == 0.0 ? 0.0 : std::max(throttle * profile.swing.lift, kLowestLift * profile.swing.clearance);
  const Vec3 move = rotation_z(context.from.heading()) * Vec3(command.axes[0], command.axes[1], 0);
  return {profile.reach.foot * move.head<2>(),
          yaw_of(context.from.sole[side].R) + profile.reach.rotation * command.axes[5], lift};
}

std::vector<Goal> Guide::foot_goals(const GuideContext& context, Side side, const Pose& sole, bool stands) const {
  const bool up = !context.from.contact[side];
  Goal goal = stay(context, foot(side));
  goal.swing = side;
  goal.contact[side] = stands;
  goal.sole[side] = sole;
  if (stands) {
    goal.kind = up ? SegmentKind::lower : SegmentKind::step;
  } else {
    goal.kind = up ? SegmentKind::air : SegmentKind::lift;
  }
  goal.com = com_above(context, goal);
  goal.trunk = rotation_z(mean_yaw(goal.sole)) * inclination(goal.trunk);
  std::vector<Goal> goals{goal};
  add_nominal(context, goal, goals);
  return goals;
}

Command Guide::within_region(const GuideContext& context, const Command& command) const {
  const Profile& profile = robot_->profile();
  const Side side = side_of(command.guide);
  const Pose& now = context.from.sole[side];
  const Pose& stance = context.from.sole[other(side)];
  const Mat3 heading = rotation_z(context.from.heading());
  const Mat3 from_stance = rotation_z(yaw_of(stance.R));
  Vec3 level = command.axes.head<3>();
  level.z() = 0.0;
  Vec3 there = from_stance.transpose() * (now.p + heading * level * profile.reach.foot - stance.p);
  const Range& ahead = profile.region.foot_x;
  const Range& outward = profile.region.foot_lateral;
  there.x() = std::clamp(there.x(), ahead.lo, ahead.hi);
  there.y() = sign_of(side) * std::clamp(sign_of(side) * there.y(), outward.lo, outward.hi);
  Command within = command;
  within.axes.head<2>() =
      (heading.transpose() * (stance.p + from_stance * there - now.p)).head<2>() / profile.reach.foot;
  return within;
}

GuideResult Guide::nearest_step(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  const Side side = side_of(command.guide);
  const FootWish wished = foot_wish(context, command);
  const double length = wished.move.norm();
  if (wished.lift > 0.0 || length < kSamePlace) return std::monostate{};
  const Vec2 from = context.from.sole[side].p.head<2>();
  const Vec2 direction = wished.move / length;
  const auto leads = [&](const Vec2& at) {
    const double ahead = (at - from).dot(direction);
    return ahead >= kLeastStep * length && ahead >= kSameDirection * (at - from).norm();
  };
  const Placement placement =
      nearest_place(context, side, from + wished.move, wished.yaw, robot_->profile().region.foot_x, leads);
  if (placement.refusal || !leads(placement.sole.p.head<2>())) return std::monostate{};
  return foot_goals(context, side, placement.sole, true);
}

GuideResult Guide::other_foot_first(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  const Side side = side_of(command.guide);
  const Posture& from = context.from;
  const FootWish wished = foot_wish(context, command);
  const Vec2& move = wished.move;
  const double length = move.norm();
  if (wished.lift > 0.0 || length < kSamePlace || context.step || !from.contact.left || !from.contact.right)
    return std::monostate{};
  const Side steps = other(side);
  const Vec3 beside = rotation_z(from.heading()) * Vec3(0, sign_of(steps) * robot_->profile().stance.width, 0);
  const Vec2 wish = (from.sole[side].p + beside).head<2>() + move;
  const Vec2 direction = move / length;
  const auto leads = [&](const Vec2& at) {
    return (at - from.sole[steps].p.head<2>()).dot(direction) >= kLeastApproach * length;
  };
  const Placement placement =
      nearest_place(context, steps, wish, yaw_of(from.sole[side].R), robot_->profile().region.foot_x, leads);
  if (placement.refusal || !leads(placement.sole.p.head<2>())) return std::monostate{};
  return foot_goals(context, steps, placement.sole, true);
}

}  // namespace baton
