#include "baton/guide/rules.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr double kSideways = 0.5;  ///< ratio of lateral to forward displacement above which a push is sideways
constexpr double kStraight = 0.1;  ///< the same ratio below which it is straight ahead or back
constexpr std::array<double, 2> kCaptureShares{1.0, 0.5};       ///< shares of the displacement that capture steps try
constexpr std::array<double, 3> kStopDistances{1.0, 1.5, 0.5};  ///< tried for a COM with speed v [v/ω]
constexpr std::array<double, 3> kStraighter{1.0, 0.6, 0.2};     ///< shares of the way to the highest COM, to cool

}  // namespace

Goal Guide::landing(const GuideContext& context, Side side, const Pose& sole) const {
  Goal goal = stay(context, foot(side));
  goal.kind = SegmentKind::lower;
  goal.swing = side;
  goal.contact[side] = true;
  goal.sole[side] = sole;
  goal.com = com_above(context, goal);
  goal.trunk = rotation_z(mean_yaw(goal.sole)) * inclination(goal.trunk);
  return goal;
}

GuideResult Guide::landings(const GuideContext& context, Side side) const {
  const Profile& profile = robot_->profile();
  const Pose& now = context.from.sole[side];
  const Pose& last = context.foothold[side];
  const Placement here =
      place(context, side, now.p.head<2>(), yaw_of(now.R), 0.0, extended(foot_region(), context, side));
  // The latest foothold stays valid, even if the stance foot has since come to rest slightly outside the region, or
  // odometry now puts it slightly closer to an edge.
  FootRegion stood = extended(foot_region(), context, side);
  stood.forward.lo -= profile.reach.foot;
  stood.forward.hi += profile.reach.foot;
  const Placement back = place(context, side, last.p.head<2>(), yaw_of(last.R), 0.0, stood, 0.0);
  const Placement near =
      nearest_place(context, side, now.p.head<2>(), yaw_of(now.R), {stride_region().forward, foot_region().outward});
  std::vector<Goal> goals;
  for (const double down : {0.0, profile.reach.trunk}) {
    for (const Placement* placement : {&here, &back, &near}) {
      if (placement->refusal) continue;
      Goal goal = landing(context, side, placement->sole);
      goal.returns = placement == &back;
      const double height = context.from.com.z() - context.from.support_height();
      goal.com.z() -= std::min(down, std::max(0.0, height - profile.region.com_height.lo));
      goals.push_back(std::move(goal));
    }
  }
  if (goals.empty()) return *here.refusal;
  return goals;
}

GuideResult Guide::stops(const GuideContext& context) const {
  const Posture& from = context.from;
  if (context.step) {
    GuideResult landed = landings(context, context.step->side);
    const auto* goals = std::get_if<std::vector<Goal>>(&landed);
    if (goals == nullptr) return landed;
    return std::vector<Goal>{landing(context, context.step->side, context.step->to), goals->front()};
  }
  const ConvexPolygon support =
      support_polygon(*robot_, from.sole, from.contact, from.com, support_plane(from.sole, from.contact))
          .inset(robot_->profile().margin.stand_on);
  std::vector<Goal> goals;
  for (const double way : kStopDistances) {
    Goal goal = stay(context, Part::trunk);
    const Vec2 ahead = (from.com + way / robot_->omega() * from.dcom).head<2>();
    goal.com.head<2>() = support.nearest(ahead + context.com_offset) - context.com_offset;
    goals.push_back(std::move(goal));
  }
  return goals;
}

std::vector<Goal> Guide::straighter(const GuideContext& context) const {
  std::vector<Goal> goals;
  Goal goal = stay(context, Part::trunk);
  const Vec3 middle = com_above(context, goal);
  const double height = context.from.com.z() - context.from.support_height();
  const double rise = std::max(0.0, robot_->profile().region.com_height.hi - height);
  for (const Mat3& trunk : {Mat3(goal.trunk), rotation_z(mean_yaw(goal.sole))}) {
    const bool turned = rotation_error(trunk, goal.trunk).norm() > kSameYaw;
    goal.trunk = trunk;
    for (const double share : kStraighter) {
      goal.com = middle + Vec3(0, 0, share * rise);
      if ((goal.com - context.from.com).norm() > same_place() || turned) goals.push_back(goal);
    }
  }
  return goals;
}

GuideResult Guide::capture_steps(const GuideContext& context, const Vec2& by, bool aside) const {
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  std::vector<Goal> goals;
  const auto add = [&](Side side, const Vec2& at, double yaw, SegmentKind kind) {
    const Placement placement = nearest_place(context, side, at, yaw, foot_region());
    if (placement.refusal) return;
    Goal goal = landing(context, side, placement.sole);
    goal.kind = kind;
    goals.push_back(goal);
    add_nominal(context, goal, goals);
  };
  const auto land = [&](Side side, const Vec3& at, double yaw, SegmentKind kind) {
    for (const double share : kCaptureShares)
      add(side, at.head<2>() + share * by, yaw, kind);
  };
  const auto beside = [&](Side side) {
    const Pose& stance = from.sole[other(side)];
    return Vec3(stance.p + stance.R * Vec3(0, sign_of(side) * profile.stance.width, 0));
  };
  if (context.step) {
    const Pose& to = context.step->to;
    land(context.step->side, to.p, yaw_of(to.R), SegmentKind::lower);
  } else if (from.contact.left && from.contact.right) {
    const Vec3 ahead = rotation_z(-from.heading()) * Vec3(by.x(), by.y(), 0);
    if (!aside && std::abs(ahead.y()) > kSideways * std::abs(ahead.x())) return std::monostate{};
    // A sideways push loads the foot on that side, so the other one steps. After a straight push it is the one that
    // carries less.
    const bool straight = std::abs(ahead.y()) < kStraight * std::abs(ahead.x());
    const Side first = straight ? farther_foot(context, from.com.head<2>() + context.com_offset)
                                : (ahead.y() < 0.0 ? Side::left : Side::right);
    // A foot about to lift off comes first; it may still carry the weight, so the other is tried, too.
    const Side best = from.lift_off ? from.lift_off->side : first;
    for (const Side side : {best, other(best)}) {
      if (!straight && !from.lift_off && side != best) continue;
      land(side, beside(side), yaw_of(from.sole[other(side)].R), SegmentKind::step);
    }
  } else {
    const Side up = from.contact.left ? Side::right : Side::left;
    const Pose& now = from.sole[up];
    land(up, now.p, yaw_of(now.R), SegmentKind::lower);
    land(up, beside(up), yaw_of(now.R), SegmentKind::lower);
  }
  if (goals.empty()) return std::monostate{};
  return goals;
}

}  // namespace baton
