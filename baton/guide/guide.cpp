#include "baton/guide/guide.hpp"

#include <algorithm>
#include <cmath>

#include "baton/guide/rules.hpp"
#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr double kLeastDeflection = 1e-6;  ///< displacements below this are rounding errors [reach]

/// Appends each of the goals with these arms.
void append_with_arms(std::vector<Goal>& goals, const VecX& arms) {
  const std::size_t count = goals.size();
  for (std::size_t i = 0; i < count; ++i) {
    goals.push_back(goals[i]);
    goals.back().arms = arms;
  }
}

}  // namespace

GuideResult Guide::goals(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  if (const std::optional<Side> side = lands_first(context, command)) return landings(context, *side);
  if (command.recall == Recall::home) return go_home(context);
  const std::optional<Target> target = this->target(context, command);
  return target ? goals(context, *target) : std::monostate{};
}

std::optional<Side> Guide::lands_first(const GuideContext& context, const Command& command) const {
  for (const Side side : kSides) {
    if (context.from.contact[side]) continue;
    const bool guided = command.guide == foot(side) && command.recall == Recall::none;
    // A guided foot whose stick and lever are released makes the same landings as were verified before it was lifted:
    // `Strategy::no_landing`.
    if (!guided || (requested_move(*robot_, command).isZero(0.0) && command.lift[side] < kLeastLift)) return side;
  }
  return std::nullopt;
}

std::optional<Target> Guide::target(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  const bool busy = context.step && is_foot(command.guide) && side_of(command.guide) != context.step->side;
  if (command.recall != Recall::none || busy || lands_first(context, command)) return std::nullopt;
  if (is_foot(command.guide)) return foot_target(context, command);
  const Target target{.part = command.guide, .move = requested_move(*robot_, command)};
  if (target.move.isZero(0.0)) return std::nullopt;
  return target;
}

GuideResult Guide::goals(const GuideContext& context, const Target& target) const {
  if (is_foot(target.part)) return guide_foot(context, target);
  if (is_hand(target.part)) return guide_hand(context, target);
  GuideResult result = guide_trunk(context, target);
  auto* goals = std::get_if<std::vector<Goal>>(&result);
  const VecX arms = stay(context, target.part).arms;
  if (goals == nullptr || goals->empty() || (goals->front().arms - arms).cwiseAbs().maxCoeff() < kSameYaw)
    return result;
  // Where arms cannot go home, as past the trunk, they stay.
  append_with_arms(*goals, arms);
  return result;
}

Target Guide::part_of(const GuideContext& context, const Target& target, double share) const {
  Target part = target;
  part.move *= share;
  if (target.lift == 0.0) return part;  // a foot that is to land does not stay in the air
  const Side side = side_of(target.part);
  const double now = context.from.contact[side] ? 0.0 : height_above_terrain(context, side);
  part.lift = std::max(least_lift(robot_->profile()), now + share * (target.lift - now));
  return part;
}

std::vector<Target> Guide::single_axes(const Target& target) const {
  const Vec6 deflection = target.move.cwiseQuotient(reach_of(*robot_, target.part)).cwiseAbs();
  std::vector<int> axes{0, 1, 2, 3, 4, 5};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return deflection[a] > deflection[b]; });
  std::vector<Target> singles;
  for (const int axis : axes) {
    if (deflection[axis] < kLeastDeflection) continue;
    Target& single = singles.emplace_back(target);
    single.move.setZero();
    single.move[axis] = target.move[axis];
  }
  return singles;
}

double Guide::same_place() const {
  return kSamePlace * robot_->profile().stance.com_height;
}

Goal Guide::initial_stance(const GuideContext& context, Goal goal) const {
  goal.trunk = rotation_z(mean_yaw(goal.sole));
  const Vec3 middle = 0.5 * (goal.sole.left.p + goal.sole.right.p);
  goal.com = com_for(context, middle + Vec3(0, 0, robot_->profile().stance.com_height));
  return goal;
}

std::vector<Goal> Guide::home_steps(const GuideContext& context) const {
  const Posture& from = context.from;
  std::vector<Goal> goals;
  for (const Side side : {other(context.last_step), context.last_step}) {
    const Pose& stance = from.sole[other(side)];
    const Mat3 R = rotation_z(yaw_of(stance.R));
    const Vec3 at = stance.p + R * Vec3(0, sign_of(side) * robot_->profile().stance.width, 0);
    const bool there = (at - from.sole[side].p).head<2>().norm() < same_place() &&
                       std::abs(wrap_angle(yaw_of(R) - yaw_of(from.sole[side].R))) < kSameYaw;
    if (there) continue;
    for (const double yaw : {yaw_of(stance.R), yaw_of(from.sole[side].R)}) {
      const Placement placement = nearest_place(context, side, at.head<2>(), yaw, foot_region());
      const double nearer = (at - from.sole[side].p).head<2>().norm() - (at - placement.sole.p).head<2>().norm();
      const double turned = std::abs(wrap_angle(yaw_of(stance.R) - yaw_of(from.sole[side].R))) -
                            std::abs(wrap_angle(yaw_of(stance.R) - yaw_of(placement.sole.R)));
      if (placement.refusal || (nearer < same_place() && turned < kSameYaw)) continue;
      Goal goal = stay(context, Part::trunk);
      arms_home(goal);
      goal.kind = SegmentKind::step;
      goal.swing = side;
      goal.sole[side] = placement.sole;
      goals.push_back(initial_stance(context, std::move(goal)));
    }
  }
  return goals;
}

std::vector<Goal> Guide::closing_steps(const GuideContext& context, bool forward) const {
  const BySide<bool>& contact = context.from.contact;
  if (!contact.left || !contact.right) return {};
  const auto left_ahead = [&](const BySide<Pose>& sole) {
    return (rotation_z(-context.from.heading()) * (sole.left.p - sole.right.p)).x();
  };
  const double ahead = left_ahead(context.from.sole);
  if (std::abs(ahead) < robot_->profile().region.stride + same_place()) return {};
  std::vector<Goal> steps = home_steps(context);
  std::erase_if(steps,
                [&](const Goal& step) { return std::abs(left_ahead(step.sole)) > std::abs(ahead) - same_place(); });
  const Side first = (ahead > 0.0) == forward ? Side::right : Side::left;
  std::ranges::stable_partition(steps, [&](const Goal& step) { return step.swing == first; });
  // Where arms cannot go home, they stay.
  append_with_arms(steps, stay(context, Part::trunk).arms);
  return steps;
}

GuideResult Guide::go_home(const GuideContext& context) const {
  const Posture& from = context.from;
  std::vector<Goal> goals = home_steps(context);
  const Goal now = stay(context, Part::trunk);
  Goal home = initial_stance(context, now);
  arms_home(home);
  const bool there = (home.com - from.com).norm() < same_place() &&
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

Goal Guide::staying(const GuideContext& context, Part guided) const {
  Goal goal = stay(context, guided);
  goal.kind = SegmentKind::arms;
  for (const Side side : kSides) {
    if (!goal.contact[side]) goal.swing = side;
  }
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
  return com_for(context, sum / soles + Vec3(0, 0, height));
}

Vec3 Guide::com_for(const GuideContext& context, const Vec3& at) {
  return at - Vec3(context.com_offset.x(), context.com_offset.y(), 0.0);
}

void Guide::add_nominal(const GuideContext& context, Goal goal, std::vector<Goal>& goals) const {
  const double height = context.from.com.z() - context.from.support_height();
  const double asked = goal.com.z();
  const double rise = com_above(context, goal).z() - height + robot_->profile().stance.com_height - asked;
  if (std::abs(rise) > same_place()) {
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
