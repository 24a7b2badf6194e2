#include "baton/guide/rules.hpp"

#include <algorithm>
#include <cmath>

#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr double kGrid = 0.01;       ///< grid spacing of the foothold search, for robots of any size [m]
constexpr double kFineGrid = 0.002;  ///< the same straight ahead, as most edges lie across [m]
constexpr double kRounding = 1e-9;   ///< rounding tolerance at the border of the region [m, rad]

/// Distance of a value outside a range; negative inside.
double excess(double value, const Range& range) {
  return std::max(range.lo - value, value - range.hi);
}

/// The range extended to a value.
Range extended(const Range& range, double value) {
  return {std::min(range.lo, value), std::max(range.hi, value)};
}

}  // namespace

Guide::Placement Guide::place(const GuideContext& context, Side side, const Vec2& at, double yaw, double lift,
                              const Range& forward, std::optional<double> edge, bool from_here) const {
  const Profile& profile = robot_->profile();
  const Part part = foot(side);
  const Pose& stance = context.from.sole[other(side)];
  Placement placement;
  placement.sole = {Vec3(at.x(), at.y(), stance.p.z()), rotation_z(yaw)};
  // The region, in the stance sole's frame.
  const double stance_yaw = yaw_of(stance.R);
  const Vec3 relative = rotation_z(-stance_yaw) * (placement.sole.p - stance.p);
  const double lateral = sign_of(side) * relative.y();
  Range ahead = forward;
  Range outward = profile.region.foot_lateral;
  if (from_here) {
    const Vec3 now = rotation_z(-stance_yaw) * (context.from.sole[side].p - stance.p);
    ahead = extended(ahead, now.x());
    outward = extended(outward, sign_of(side) * now.y());
  }
  const double turned = wrap_angle(yaw - stance_yaw);
  if (excess(relative.x(), ahead) > kRounding) {
    placement.refusal = {Reason::foot_region, part, relative.x(), nearest_limit(relative.x(), ahead), "forward"};
  } else if (excess(lateral, outward) > kRounding) {
    placement.refusal = {Reason::foot_region, part, lateral, nearest_limit(lateral, outward), "sideways"};
  } else if (std::abs(turned) > profile.region.foot_yaw + kRounding) {
    placement.refusal = {Reason::foot_yaw, part, std::abs(turned), profile.region.foot_yaw, ""};
  }
  if (placement.refusal) return placement;
  const ConvexPolygon outline = sole_outline(*robot_, side, placement.sole);
  const double gap = separation(outline, sole_outline(*robot_, other(side), stance));
  if (gap < profile.region.sole_gap) {
    placement.refusal = {Reason::sole_gap, part, gap, profile.region.sole_gap, ""};
    return placement;
  }
  const ConvexPolygon in_world = sole_outline(*robot_, side, context.anchor * placement.sole);
  if (lift > 0.0) {
    const double ground = world_->highest_under(in_world) - context.anchor.p.z();
    if (!std::isfinite(ground)) placement.refusal = {Reason::ground, part, 0, 0, "nothing below"};
    placement.sole.p.z() = ground + lift;
    return placement;
  }
  const Foothold foothold =
      world_->foothold(in_world, profile.ground, edge.value_or(profile.margin.edge + context.place_uncertainty));
  if (!foothold.flat) {
    placement.refusal = {Reason::ground, part, foothold.deviation, profile.ground.flatness, ""};
    return placement;
  }
  placement.sole.p.z() = foothold.height - context.anchor.p.z();
  const Vec3 up = context.anchor.R.transpose() * foothold.normal;
  placement.sole.R = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), up).toRotationMatrix() * placement.sole.R;
  return placement;
}

Guide::Placement Guide::nearest_place(const GuideContext& context, Side side, const Vec2& at, double yaw,
                                      const Range& forward, const std::function<bool(const Vec2&)>& serves) const {
  const Profile::Region& region = robot_->profile().region;
  const Pose& stance = context.from.sole[other(side)];
  const double stance_yaw = yaw_of(stance.R);
  const double turned = std::clamp(wrap_angle(yaw - stance_yaw), -region.foot_yaw, region.foot_yaw);
  const Mat3 from_stance = rotation_z(stance_yaw);
  const Vec3 wish = from_stance.transpose() * (Vec3(at.x(), at.y(), stance.p.z()) - stance.p);
  // Candidates: the wish clamped to the region, a fine line ahead and a coarse grid; nearest first.
  std::vector<Vec2> places;
  const double lateral_wish = std::clamp(sign_of(side) * wish.y(), region.foot_lateral.lo, region.foot_lateral.hi);
  places.emplace_back(std::clamp(wish.x(), forward.lo, forward.hi), sign_of(side) * lateral_wish);
  for (double x = forward.lo; x <= forward.hi + 1e-9; x += kFineGrid)
    places.emplace_back(x, places.front().y());
  for (double x = forward.lo; x <= forward.hi + 1e-9; x += kGrid) {
    for (double y = region.foot_lateral.lo; y <= region.foot_lateral.hi + 1e-9; y += kGrid) {
      places.emplace_back(x, sign_of(side) * y);
    }
  }
  const Vec2 target = wish.head<2>();
  std::stable_sort(places.begin(), places.end(), [&](const Vec2& a, const Vec2& b) {
    return (a - target).squaredNorm() < (b - target).squaredNorm();
  });
  Placement first;
  for (const Vec2& candidate : places) {
    const Vec3 p = stance.p + from_stance * Vec3(candidate.x(), candidate.y(), 0);
    if (serves && !serves(p.head<2>())) continue;
    Placement placement = place(context, side, p.head<2>(), stance_yaw + turned, 0.0, forward);
    if (!placement.refusal) return placement;
    if (!first.refusal) first = placement;
  }
  return first;
}

}  // namespace baton
