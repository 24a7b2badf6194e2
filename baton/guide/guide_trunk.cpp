#include "baton/guide/rules.hpp"

#include <algorithm>
#include <cmath>

#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr double kLeastProgress = 0.01;  ///< share of the requested displacement below which a goal is no progress
constexpr double kRounding = 1e-6;       ///< displacements below this are rounding errors [m, rad]
constexpr double kMostLeft = 2.0;        ///< displacement that a step may leave for the next ones [same_place]
constexpr double kInside = 0.096;        ///< of the COM at rest on both feet, inside the support polygon [COM height]
constexpr double kWidthStep = 3.0;       ///< largest change of the feet's lateral distance by a step [same_place]

static_assert(0.5 * kWidthStep < kMostLeft, "half of a change of the distance moves the middle of the feet");

/// The angle by which a step turns the line between the feet about the other foot, as much as their mean yaw [rad].
/// @param yaw of the stepping foot after the step
double turn_of_line(const Posture& from, Side side, double yaw) {
  return 0.5 * wrap_angle(yaw - yaw_of(from.sole[side].R));
}

/// How the middle of the feet moves by that [m].
Vec2 moved_by_turn(const GuideContext& context, const Goal& step) {
  if (!step.swing) return Vec2::Zero();
  const Side side = *step.swing;
  const double turn = turn_of_line(context.from, side, yaw_of(step.sole[side].R));
  const Vec2 from_stance = (step.com - context.from.sole[other(side)].p).head<2>() + context.com_offset;
  return from_stance - Eigen::Rotation2Dd(-turn) * from_stance;
}

}  // namespace

GuideResult Guide::guide_trunk(const GuideContext& context, const Target& target) const {
  const Profile::Region& region = robot_->profile().region;
  const Posture& from = context.from;
  const Mat3 heading = rotation_z(from.heading());
  Goal goal = stay(context, Part::trunk);
  goal.com += heading * walking_on(context, target.move.head<3>());
  const double support = from.support_height();
  const double asked = goal.com.z() - support;
  goal.com.z() = support + region.com_height.clamped(asked);
  const Mat3 turned = rotation_exp(heading * target.move.tail<3>()) * from.trunk;
  // A trunk at its largest tilt leans no farther, but follows the rest of the command.
  goal.trunk = limit_tilt(turned, region.trunk_inclination);
  const auto none = [](const Vec3& made, const auto& requested) {
    return made.norm() < kLeastProgress * requested.norm() + kRounding;
  };
  const bool still = none(goal.com - from.com, target.move.head<3>());
  if (still && tilt_of(turned) > std::max(region.trunk_inclination, tilt_of(from.trunk) - kRounding))
    return Refusal{Reason::trunk_inclination, Part::trunk, tilt_of(turned), region.trunk_inclination, ""};
  if (still && none(rotation_error(goal.trunk, from.trunk), target.move.tail<3>()))
    return Refusal{Reason::com_height, Part::trunk, asked, region.com_height.clamped(asked), ""};
  const Mat3& R = context.drift_correction.R;
  const Vec3 uncorrected = goal.com;
  goal.com.head<2>() = (context.drift_correction * goal.com).head<2>();
  goal.trunk = R * goal.trunk;
  arms_home(goal);
  GuideResult result = stand_under(context, goal);
  auto* goals = std::get_if<std::vector<Goal>>(&result);
  for (std::size_t i = 0; goals != nullptr && i < goals->size(); ++i) {
    // What a step leaves of the displacement is drift, for the next ones to correct. A goal that is farther from it, as
    // before an edge, corrects yaw alone.
    Goal& made = (*goals)[i];
    const Vec2 by_turn = moved_by_turn(context, made);
    const bool there = (made.com.head<2>() - by_turn - goal.com.head<2>()).norm() < kMostLeft * same_place();
    made.drift_correction = {made.com - R * (there ? uncorrected : made.com), R};
    if (there) made.drift_correction.p.head<2>() -= by_turn;
    made.drift_correction.p.z() = 0.0;
  }
  return result;
}

Vec3 Guide::walking_on(const GuideContext& context, Vec3 move) const {
  const double length = move.head<2>().norm();
  if (!context.stick_held || context.step || length < kRounding) return move;
  const BySide<Pose>& sole = context.from.sole;
  const Vec3 apart = rotation_z(-context.from.heading()) * (sole.left.p - sole.right.p);
  const double ahead = 0.5 * std::abs(apart.x() * move.x()) / length;
  move.head<2>() *= 1.0 + std::min(1.0, ahead / length);
  return move;
}

GuideResult Guide::stand_under(const GuideContext& context, const Goal& goal) const {
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  const double yaw = yaw_of(goal.trunk);
  const ConvexPolygon support =
      support_polygon(*robot_, from.sole, from.contact, goal.com, support_plane(from.sole, from.contact));
  const Vec2 target = goal.com.head<2>() + context.com_offset;
  const bool turn = goal.guided == Part::trunk && std::abs(wrap_angle(yaw - from.heading())) > profile.region.trunk_yaw;
  // What the robot must withstand grows with its height, and on both feet even narrow soles leave that room. The way
  // inwards is open from anywhere.
  const double inside = support.margin(target);
  const bool both = from.contact.left && from.contact.right;
  const double now = support.margin(from.com.head<2>() + context.com_offset);
  const double enough = both ? std::min(kInside * profile.stance.com_height, now) : 0.0;
  const bool stands = inside >= std::max(profile.margin.stand_on, enough);
  std::vector<Goal> goals;
  const bool stays = stands && !turn && !context.step;
  const bool walks = context.stick_held && goal.guided == Part::trunk;
  // Without horizontal motion or turn, a step does not help.
  if (stays && (goal.com - from.com).head<2>().norm() < same_place()) return std::vector<Goal>{goal};
  if (stays && !walks) goals.push_back(goal);
  std::optional<Refusal> refusal = add_steps(context, goal, turn, stride_region(), goals);
  if (goals.empty()) refusal = add_steps(context, goal, turn, foot_region(), goals);
  if (context.step) goals.push_back(stepping(context, goal, context.step->side, context.step->to));
  if (stays && walks) goals.push_back(goal);
  // If no foot can follow, the trunk alone turns, within the yaw limit of the feet.
  const bool turns_alone = stands && turn && !context.step;
  if (turns_alone && std::abs(wrap_angle(yaw - from.heading())) <= profile.region.foot_yaw) goals.push_back(goal);
  const auto step = std::find_if(goals.begin(), goals.end(), [](const Goal& g) { return g.kind == SegmentKind::step; });
  if (step != goals.end()) add_nominal(context, *step, goals);
  if (!goals.empty()) return goals;
  return refusal_by(Reason::no_progress, *refusal);
}

Goal Guide::stepping(const GuideContext& context, const Goal& goal, Side side, const Pose& sole) const {
  Goal stepping = goal;
  stepping.kind = SegmentKind::step;
  stepping.swing = side;
  stepping.sole[side] = sole;
  // Above the middle of the feet, at the requested height above the soles in contact.
  const double height = goal.com.z() - context.from.support_height();
  stepping.com = com_for(context, 0.5 * (stepping.sole.left.p + stepping.sole.right.p) + Vec3(0, 0, height));
  return stepping;
}

Side Guide::farther_foot(const GuideContext& context, const Vec2& place) const {
  const auto distance = [&](Side side) { return (context.from.sole[side].p.head<2>() - place).norm(); };
  const double difference = distance(Side::left) - distance(Side::right);
  if (std::abs(difference) <= same_place()) return other(context.last_step);
  return difference > 0.0 ? Side::left : Side::right;
}

Vec2 Guide::opposite(const GuideContext& context, Side side, const Vec2& target, double yaw) const {
  const Posture& from = context.from;
  const Vec2 stance = from.sole[other(side)].p.head<2>();
  const Vec2 outward = sign_of(side) * Vec2(-std::sin(yaw), std::cos(yaw));
  const double moved = outward.dot(target - 0.5 * (stance + from.sole[side].p.head<2>()));
  const double wide = outward.dot(target - stance) - std::max(0.0, moved) - 0.5 * robot_->profile().stance.width;
  const double band = same_place();
  const double narrows = std::clamp(beyond(wide, band), -kWidthStep * band, kWidthStep * band);
  // The line between the feet turns with them.
  const Eigen::Rotation2Dd turn(turn_of_line(from, side, yaw));
  return stance + turn * Vec2(2.0 * (target - stance)) - narrows * outward;
}

std::optional<Refusal> Guide::add_steps(const GuideContext& context, const Goal& goal, bool turn,
                                        const FootRegion& region, std::vector<Goal>& goals) const {
  const Posture& from = context.from;
  const double yaw = yaw_of(goal.trunk);
  const Vec2 target = goal.com.head<2>() + context.com_offset;
  const Side first = farther_foot(context, target);
  const BySide<Vec2> wish{opposite(context, Side::left, target, yaw), opposite(context, Side::right, target, yaw)};
  std::optional<Refusal> refusal;
  BySide<bool> placed{false, false};
  const std::vector<Side> feet = context.step ? std::vector{context.step->side} : std::vector{first, other(first)};
  for (const Side side : feet) {
    const Placement placement = place(context, side, wish[side], yaw, 0.0, region);
    placed[side] = !placement.refusal;
    if (placed[side]) goals.push_back(stepping(context, goal, side, placement.sole));
    if (!placed[side] && !refusal) refusal = placement.refusal;
  }
  // Then the valid foothold nearest to the ideal one, for each foot, if it is progress: the better one first.
  const Vec2 middle = 0.5 * (from.sole.left.p + from.sole.right.p).head<2>();
  std::vector<std::pair<double, std::pair<Side, Pose>>> nearest;
  for (const Side side : feet) {
    const Placement candidate = nearest_place(context, side, wish[side], yaw, region);
    if (candidate.refusal) continue;
    const double left = 0.5 * (candidate.sole.p.head<2>() - wish[side]).norm();
    const double turned =
        std::abs(wrap_angle(yaw - yaw_of(from.sole[side].R))) - std::abs(wrap_angle(yaw - yaw_of(candidate.sole.R)));
    const bool nearer = left < (middle - target).norm() - same_place();
    const bool turns = turn && turned > kSameYaw && left < (middle - target).norm() + robot_->profile().reach.trunk;
    const bool another = !placed[side] || left > same_place();
    if (another && (nearer || turns)) nearest.push_back({left, {side, candidate.sole}});
  }
  if (nearest.size() == 2 && nearest[1].first < nearest[0].first - same_place()) std::swap(nearest[0], nearest[1]);
  for (const auto& [left, step] : nearest)
    goals.push_back(stepping(context, goal, step.first, step.second));
  return refusal;
}

}  // namespace baton
