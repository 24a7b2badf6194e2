#include "baton/guide/rules.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kLeastStep = 0.5;  ///< least progress of a step to another foothold, share of the requested distance
constexpr double kLeastApproach = 0.1;  ///< least progress of a step of the other foot, share of the requested distance

/// Horizontal displacement of a foot, in the planning frame [m].
Vec2 level_move(const GuideContext& context, const Target& target) {
  const Vec3 level(target.move[0], target.move[1], 0.0);
  return (rotation_z(context.from.heading()) * level).head<2>();
}

}  // namespace

std::optional<Target> Guide::foot_target(const GuideContext& context, const Command& command) const {
  const Profile& profile = robot_->profile();
  const Side side = side_of(command.guide);
  const double lever = command.lift[side];
  Target target{.part = command.guide, .move = requested_move(*robot_, command)};
  if (lever >= kLeastLift) target.lift = std::max(lever * profile.swing.lift, least_lift(profile));
  if (!target.move.isZero(0.0)) return target;
  const double now = context.from.contact[side] ? 0.0 : height_above_terrain(context, side);
  if (std::abs(target.lift - now) <= same_place()) return std::nullopt;
  return target;
}

GuideResult Guide::guide_foot(const GuideContext& context, const Target& target) const {
  const Side side = side_of(target.part);
  const Pose& now = context.from.sole[side];
  const Vec2 at = now.p.head<2>() + level_move(context, target);
  const FootRegion region = extended(foot_region(), context, side);
  const Placement placement = place(context, side, at, yaw_of(now.R) + target.move[5], target.lift, region);
  if (placement.refusal) return *placement.refusal;
  return foot_goals(context, side, placement.sole, target.lift == 0.0);
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

Target Guide::within_region(const GuideContext& context, const Target& target) const {
  const Side side = side_of(target.part);
  const Pose& now = context.from.sole[side];
  const Pose& stance = context.from.sole[other(side)];
  const Mat3 from_stance = rotation_z(yaw_of(stance.R));
  const Vec2 move = level_move(context, target);
  const auto [forward, outward] = foot_region();
  Vec3 there = from_stance.transpose() * (now.p + Vec3(move.x(), move.y(), 0.0) - stance.p);
  there.x() = forward.clamped(there.x());
  there.y() = sign_of(side) * outward.clamped(sign_of(side) * there.y());
  Target within = target;
  within.move.head<2>() = (rotation_z(-context.from.heading()) * (stance.p + from_stance * there - now.p)).head<2>();
  return within;
}

GuideResult Guide::nearest_step(const GuideContext& context, const Target& target) const {
  if (target.lift > 0.0) return std::monostate{};
  const Side side = side_of(target.part);
  const Pose& now = context.from.sole[side];
  const Vec2 move = level_move(context, target);
  return step_along(context, side, now.p.head<2>() + move, yaw_of(now.R) + target.move[5], move, kLeastStep,
                    kSameDirection);
}

GuideResult Guide::other_foot_first(const GuideContext& context, const Target& target) const {
  const Posture& from = context.from;
  if (target.lift > 0.0 || context.step || !from.contact.left || !from.contact.right) return std::monostate{};
  const Pose& guided = from.sole[side_of(target.part)];
  const Side side = other(side_of(target.part));
  const Vec3 beside = rotation_z(from.heading()) * Vec3(0, sign_of(side) * robot_->profile().stance.width, 0);
  const Vec2 move = level_move(context, target);
  return step_along(context, side, (guided.p + beside).head<2>() + move, yaw_of(guided.R), move, kLeastApproach, 0.0);
}

GuideResult Guide::step_along(const GuideContext& context, Side side, const Vec2& at, double yaw, const Vec2& move,
                              double least, double direction) const {
  const double length = move.norm();
  if (length < same_place()) return std::monostate{};
  const auto leads = [&](const Vec2& place) {
    const Vec2 way = place - context.from.sole[side].p.head<2>();
    const double ahead = way.dot(move) / length;
    return ahead >= least * length && ahead >= direction * way.norm();
  };
  const Placement placement = nearest_place(context, side, at, yaw, foot_region(), leads);
  if (placement.refusal || !leads(placement.sole.p.head<2>())) return std::monostate{};
  return foot_goals(context, side, placement.sole, true);
}

}  // namespace baton
