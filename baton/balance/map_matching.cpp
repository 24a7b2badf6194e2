#include "baton/balance/map_matching.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

// Lengths are in COM heights, rates in ω, times in 1/ω.
constexpr double kHeightRate = 0.16;    ///< at which heights follow those of the terrain
constexpr double kAirborneTime = 0.6;   ///< time without contact after which the height is unknown
constexpr double kMapTolerance = 0.05;  ///< a sole farther above or below the terrain stands elsewhere
constexpr double kSameGap = 0.015;      ///< difference of the soles' heights above the terrain that count as the same

// Soles at a terrain edge.
constexpr double kLeastTilt = 0.08;         ///< of the sole against the terrain; unmapped slopes are below this [rad]
constexpr double kCornerInset = 0.01;       ///< overlap of sole and edge
constexpr double kLeastEdge = 0.02;         ///< height of the lowest edge that counts
constexpr double kHeightTolerance = 0.015;  ///< between a corner and the terrain that it stands on
constexpr double kEdgeRange = 0.05;         ///< largest distance of the edge from the corner
constexpr double kCornerOutset = 0.002;     ///< least distance of sole and higher ground
constexpr double kElsewhere = 0.15;         ///< largest distance of a level sole from terrain of its height
constexpr double kEdgeSpeed = 0.0065;       ///< of the correction [COM height × ω]

}  // namespace

MapMatching::MapMatching(const RobotModel& robot, const World& world)
    : world_(&world),
      com_height_(robot.profile().stance.com_height),
      omega_(robot.omega()),
      period_(robot.profile().tick.period) {
  for (const Side side : kSides) {
    corners_[side] = robot.sole(side).inset(kCornerInset * com_height_).vertices();
    outer_corners_[side] = robot.sole(side).inset(-kCornerOutset * com_height_).vertices();
  }
}

Vec3 MapMatching::correction(const Kinematics& kinematics, const BySide<Vec3>& foothold, const SoleContact& contact,
                             const BySide<bool>& planned) {
  height_lost_ = height_lost_ || omega_ * contact.airborne() > kAirborneTime;
  double off = 0.0;
  double carried = 0.0;
  Vec2 moved = Vec2::Zero();
  BySide<std::optional<double>> unmapped;  // gaps of soles without ground of their height nearby
  for (const Side side : kSides) {
    if ((!planned[side] && !height_lost_) || !contact.touch()[side]) continue;
    const Vec3& at = foothold[side];
    const std::optional<GroundPoint> ground = world_->ground(at.head<2>());
    if (!ground) continue;
    if (const std::optional<Vec2> to_edge = felt_edge(side, kinematics.sole(side).R, at, *ground)) {
      moved += *to_edge;
      continue;  // the height of a tilted sole tells nothing
    }
    const double gap = ground->height - at.z();
    if (!height_lost_) {
      const Vec2 to_there = to_own_height(side, kinematics.sole(side).R, at, *ground);
      moved += contact.load()[side] / contact.total() * to_there;
      if (std::abs(gap) > kMapTolerance * com_height_) {
        if (to_there.isZero()) unmapped[side] = gap;
        continue;
      }
    }
    off += contact.load()[side] * gap;
    carried += contact.load()[side];
  }
  // Both soles as far from the terrain: rather the estimate is wrong than the map.
  if (unmapped.left && unmapped.right && std::abs(*unmapped.left - *unmapped.right) < kSameGap * com_height_) {
    off = 0.5 * (*unmapped.left + *unmapped.right);
    carried = 1.0;
  }
  const double rise = carried > 0.0 ? off / carried : 0.0;
  // After a robot was in the air, its height is unknown: at the next contact, it is taken from the map at once.
  const bool found = height_lost_ && carried > 0.0;
  if (found) height_lost_ = false;
  moved = bounded(moved, period_ * kEdgeSpeed * omega_ * com_height_);
  return {moved.x(), moved.y(), found ? rise : period_ * kHeightRate * omega_ * rise};
}

Vec2 MapMatching::to_own_height(Side side, const Mat3& R, const Vec3& at, const GroundPoint& below) const {
  const double tolerance = kMapTolerance * com_height_;
  Vec2 farthest = Vec2::Zero();
  const auto consider = [&](const Vec2& place) {
    const std::optional<Vec2> there = world_->nearest_of_height(place, at.z(), kHeightTolerance * com_height_);
    if (!there) return;
    const Vec2 by = *there - place;
    if (by.norm() < kElsewhere * com_height_ && by.norm() > farthest.norm()) farthest = by;
  };
  if (std::abs(below.height - at.z()) > tolerance) consider(at.head<2>());
  for (const Vec2& vertex : outer_corners_[side]) {
    const Vec2 place = (at + R * Vec3(vertex.x(), vertex.y(), 0.0)).head<2>();
    const std::optional<GroundPoint> ground = world_->ground(place);
    if (ground && ground->height - at.z() > tolerance) consider(place);
  }
  return farthest;
}

std::optional<Vec2> MapMatching::felt_edge(Side side, const Mat3& R, const Vec3& at, const GroundPoint& below) const {
  if (R.col(2).dot(below.normal) > std::cos(kLeastTilt)) return std::nullopt;
  std::optional<Vec2> to_edge;
  double lowest = below.height;
  double highest = below.height;
  for (const Vec2& vertex : corners_[side]) {
    const Vec3 corner = at + R * Vec3(vertex.x(), vertex.y(), 0.0);
    const Vec2 place = corner.head<2>();
    const std::optional<GroundPoint> ground = world_->ground(place);
    if (!ground) continue;
    lowest = std::min(lowest, ground->height);
    highest = std::max(highest, ground->height);
    if (corner.z() - ground->height < kLeastEdge * com_height_) continue;
    const std::optional<Vec2> edge = world_->nearest_of_height(place, corner.z(), kHeightTolerance * com_height_);
    if (!edge || (*edge - place).norm() > kEdgeRange * com_height_) continue;
    if (!to_edge || (*edge - place).norm() < to_edge->norm()) to_edge = *edge - place;
  }
  if (to_edge) return to_edge;
  return highest - lowest > kLeastEdge * com_height_ ? std::optional<Vec2>(Vec2::Zero()) : std::nullopt;
}

}  // namespace baton
