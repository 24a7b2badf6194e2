#include "baton/guide/rules.hpp"

#include <algorithm>

namespace baton {

GuideResult Guide::guide_hand(const GuideContext& context, const Target& target) const {
  const Side side = side_of(target.part);
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  const Mat3 heading = rotation_z(from.heading());
  Goal goal = stay(context, target.part);
  goal.kind = SegmentKind::reach;
  const Pose hand{from.hand[side].p + heading * target.move.head<3>(),
                  rotation_exp(heading * target.move.tail<3>()) * from.hand[side].R};
  goal.hand[side] = hand;
  const Vec3 move = hand.p - from.hand[side].p;

  // The COM height changes only with a vertical command, and only in its direction.
  const auto with_com_moved_by = [&](const Vec3& shift) {
    Goal moved = goal;
    moved.com += Vec3(shift.x(), shift.y(), move.z() * shift.z() > 0.0 ? shift.z() : 0.0);
    const double support = from.support_height();
    moved.com.z() = support + profile.region.com_height.clamped(moved.com.z() - support);
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
