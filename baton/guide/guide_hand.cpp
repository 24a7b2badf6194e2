#include "baton/guide/rules.hpp"

#include <algorithm>

namespace baton {

GuideResult Guide::guide_hand(const GuideContext& context, const Command& command) const {
  const Side side = side_of(command.guide);
  const bool turns = robot_->hand_has_attitude(side) && !command.axes.tail<3>().isZero(0.0);
  if (command.axes.head<3>().isZero(0.0) && !turns) return std::monostate{};
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  const Mat3 heading = rotation_z(from.heading());
  Goal goal = stay(context, command.guide);
  goal.kind = SegmentKind::reach;
  Pose hand = from.hand[side];
  hand.p += heading * command.axes.head<3>() * profile.reach.hand;
  if (turns) hand.R = rotation_exp(heading * command.axes.tail<3>() * profile.reach.rotation) * hand.R;
  goal.hand[side] = hand;

  // The COM height changes only with a vertical command, and only in its direction.
  const double up = command.axes[2];
  const auto with_com_moved_by = [&](const Vec3& shift) {
    Goal moved = goal;
    moved.com += Vec3(shift.x(), shift.y(), up * shift.z() > 0.0 ? shift.z() : 0.0);
    const double support = from.support_height();
    moved.com.z() =
        support + std::clamp(moved.com.z() - support, profile.region.com_height.lo, profile.region.com_height.hi);
    return moved;
  };
  if (context.step) return std::vector<Goal>{stepping(context, goal, context.step->side, context.step->to)};
  std::vector<Goal> goals;
  std::optional<Refusal> refusal;
  const auto add = [&](const GuideResult& more) {
    const auto* list = std::get_if<std::vector<Goal>>(&more);
    if (list != nullptr) goals.insert(goals.end(), list->begin(), list->end());
    if (list == nullptr && !refusal) refusal = std::get<Refusal>(more);
  };
  const Vec3 move = hand.p - from.hand[side].p;
  const Vec3 stretch = hand.p - from.shoulder[side];
  const double length = stretch.norm();
  if (length > profile.region.hand_distance) {
    add(stand_under(context, with_com_moved_by((length - profile.region.hand_distance) / length * stretch)));
  } else {
    goals.push_back(goal);
  }
  // If the arm cannot do it, the body moves along with the hand.
  add(stand_under(context, with_com_moved_by(move)));
  if (goals.empty()) return *refusal;
  // Or it steps in the hand's direction with the arm as it is; the hand can go on from there.
  const auto leads = std::find_if(goals.begin(), goals.end(), [&](const Goal& step) {
    const Vec3 way = step.com - from.com;
    const bool same = way.dot(move) > kSameDirection * way.norm() * move.norm() && way.norm() <= move.norm();
    return step.kind == SegmentKind::step && same;
  });
  if (leads != goals.end()) {
    goals.push_back(*leads);
    goals.back().hand[side].reset();
  }
  return goals;
}

}  // namespace baton
