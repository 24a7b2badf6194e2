#include "baton/guide/rules.hpp"

#include <algorithm>
#include <cmath>

#include "baton/model/contact.hpp"
#include "baton/model/place_margins.hpp"

namespace baton {
namespace {

constexpr double kGrid = 0.04;            ///< largest grid spacing of the foothold search [COM height]
constexpr double kFineGrid = 0.008;       ///< the same on the lines straight ahead and aside [COM height]
constexpr double kBorderRounding = 1e-9;  ///< rounding tolerance at the border of the region [m, rad]

/// Distance of a value outside a range; negative inside.
double excess(double value, const Range& range) {
  return std::max(range.lo - value, value - range.hi);
}

/// The range extended to a value.
Range with(const Range& range, double value) {
  return {std::min(range.lo, value), std::max(range.hi, value)};
}

/// Evenly spaced values over the range, its ends included.
std::vector<double> spaced(const Range& range, double most) {
  const auto intervals = std::max(1, static_cast<int>(std::ceil((range.hi - range.lo) / most - kBorderRounding)));
  std::vector<double> values;
  for (int i = 0; i <= intervals; ++i)
    values.push_back(range.lo + (range.hi - range.lo) * i / intervals);
  return values;
}

}  // namespace

double Guide::height_above_terrain(const GuideContext& context, Side side) const {
  const Pose in_world = context.anchor * context.from.sole[side];
  return in_world.p.z() - world_->highest_under(sole_outline(*robot_, side, in_world));
}

Guide::FootRegion Guide::foot_region() const {
  return {robot_->profile().region.foot_x, robot_->profile().region.foot_lateral};
}

Guide::FootRegion Guide::stride_region() const {
  // Not as near to the other foot as may be: a foot that lands some mm beside its place must not land on the other.
  const Profile& profile = robot_->profile();
  const Range& lateral = profile.region.foot_lateral;
  const double nearest = std::max(lateral.lo, 0.5 * (lateral.lo + profile.stance.width));
  return {{-profile.region.stride, profile.region.stride}, {nearest, lateral.hi}};
}

Guide::FootRegion Guide::extended(FootRegion region, const GuideContext& context, Side side) {
  const Pose& stance = context.from.sole[other(side)];
  const Vec3 now = rotation_z(-yaw_of(stance.R)) * (context.from.sole[side].p - stance.p);
  return {with(region.forward, now.x()), with(region.outward, sign_of(side) * now.y())};
}

Guide::Placement Guide::place(const GuideContext& context, Side side, const Vec2& at, double yaw, double lift,
                              const FootRegion& region, std::optional<double> edge) const {
  const Profile& profile = robot_->profile();
  const Part part = foot(side);
  const Pose& stance = context.from.sole[other(side)];
  Placement placement;
  placement.sole = {Vec3(at.x(), at.y(), stance.p.z()), rotation_z(yaw)};
  // The region, in the stance sole's frame.
  const double stance_yaw = yaw_of(stance.R);
  const Vec3 relative = rotation_z(-stance_yaw) * (placement.sole.p - stance.p);
  const double lateral = sign_of(side) * relative.y();
  const double turned = wrap_angle(yaw - stance_yaw);
  if (excess(relative.x(), region.forward) > kBorderRounding) {
    placement.refusal = {Reason::foot_region, part, relative.x(), region.forward.clamped(relative.x()), "forward"};
  } else if (excess(lateral, region.outward) > kBorderRounding) {
    placement.refusal = {Reason::foot_region, part, lateral, region.outward.clamped(lateral), "sideways"};
  } else if (std::abs(turned) > profile.region.foot_yaw + kBorderRounding) {
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
      world_->foothold(in_world, profile.ground, edge.value_or(edge_margin(*robot_, context.place_uncertainty)));
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
                                      const FootRegion& region, const std::function<bool(const Vec2&)>& serves) const {
  const auto& [forward, outward] = region;
  const Pose& stance = context.from.sole[other(side)];
  const double stance_yaw = yaw_of(stance.R);
  const double most = robot_->profile().region.foot_yaw;
  const double turned = std::clamp(wrap_angle(yaw - stance_yaw), -most, most);
  const Mat3 from_stance = rotation_z(stance_yaw);
  const Vec3 wish = from_stance.transpose() * (Vec3(at.x(), at.y(), stance.p.z()) - stance.p);
  // Candidates: the wish clamped to the region, a fine line ahead, as most edges lie across, one aside, as a leap aside
  // leads astray, and a coarse grid; nearest first.
  const double size = robot_->profile().stance.com_height;
  const double lateral = sign_of(side) * outward.clamped(sign_of(side) * wish.y());
  std::vector<Vec2> places{{forward.clamped(wish.x()), lateral}};
  for (const double x : spaced(forward, kFineGrid * size))
    places.emplace_back(x, lateral);
  for (const double y : spaced(outward, kFineGrid * size))
    places.emplace_back(forward.clamped(wish.x()), sign_of(side) * y);
  for (const double x : spaced(forward, kGrid * size)) {
    for (const double y : spaced(outward, kGrid * size))
      places.emplace_back(x, sign_of(side) * y);
  }
  const Vec2 target = wish.head<2>();
  std::stable_sort(places.begin(), places.end(), [&](const Vec2& a, const Vec2& b) {
    return (a - target).squaredNorm() < (b - target).squaredNorm();
  });
  Placement first;
  for (const Vec2& candidate : places) {
    const Vec3 p = stance.p + from_stance * Vec3(candidate.x(), candidate.y(), 0);
    if (serves && !serves(p.head<2>())) continue;
    Placement placement = place(context, side, p.head<2>(), stance_yaw + turned, 0.0, region);
    if (!placement.refusal) return placement;
    if (!first.refusal) first = placement;
  }
  return first;
}

}  // namespace baton
