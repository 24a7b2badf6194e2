#include "baton/balance/map_matching.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

// Rates and times are the same for any size of robot.
constexpr double kMap = 1.0;        ///< rate at which heights follow those of the ground [1/s]
constexpr double kInTheAir = 0.1;   ///< time without a touch from which the height is lost [s]
constexpr double kOnTheMap = 0.05;  ///< farther from the known ground a sole stands on something else [COM height]

// A sole that stands on an edge of the ground. Lengths are shares of the COM height.
constexpr double kTilted = 0.08;   ///< against the ground; a floor may be tilted by less [rad]
constexpr double kOverlap = 0.01;  ///< so much of it is on the edge
constexpr double kRaised = 0.02;   ///< least height of a step that counts
constexpr double kAsHigh = 0.015;  ///< a corner stands on what differs by less in height
constexpr double kFeels = 0.05;    ///< the edge is no farther from where it should be
constexpr double kMoves = 0.04;    ///< how fast the place is corrected [COM heights/s]

}  // namespace

MapMatching::MapMatching(const RobotModel& robot, const World& world)
    : world_(&world), size_(robot.profile().stance.com_height), period_(robot.profile().tick.period) {
  for (const Side side : kSides)
    corners_[side] = robot.sole(side).inset(kOverlap * size_).vertices();
}

Vec3 MapMatching::correction(const Kinematics& kinematics, const BySide<Vec3>& foothold, const SoleContact& contact,
                             const BySide<bool>& planned) {
  lost_ = lost_ || contact.airborne() > kInTheAir;
  double off = 0.0;
  double stand = 0.0;
  Vec2 moved = Vec2::Zero();
  for (const Side side : kSides) {
    if ((!planned[side] && !lost_) || !contact.touch()[side]) continue;
    const std::optional<GroundPoint> ground = world_->ground(foothold[side].head<2>());
    if (!ground) continue;
    if (const std::optional<Vec2> way = felt_edge(side, kinematics.sole(side).R, foothold[side], *ground)) {
      moved += bounded(*way, period_ * kMoves * size_);  // the height of a tilted sole says nothing
      continue;
    }
    const double gap = ground->height - foothold[side].z();
    if (std::abs(gap) > kOnTheMap * size_ && !lost_) continue;
    off += contact.load()[side] * gap;
    stand += contact.load()[side];
  }
  const double rise = stand > 0.0 ? off / stand : 0.0;
  // The height of a robot that was lifted, or fell, is lost: once a sole lies on the ground again, it is the map's.
  const bool found = lost_ && stand > 0.0;
  if (found) lost_ = false;
  return {moved.x(), moved.y(), found ? rise : period_ * kMap * rise};
}

std::optional<Vec2> MapMatching::felt_edge(Side side, const Mat3& R, const Vec3& at, const GroundPoint& below) const {
  if (R.col(2).dot(below.normal) > std::cos(kTilted)) return std::nullopt;
  std::optional<Vec2> way;
  double lowest = below.height;
  double highest = below.height;
  for (const Vec2& vertex : corners_[side]) {
    const Vec3 corner = at + R * Vec3(vertex.x(), vertex.y(), 0.0);
    const Vec2 place = corner.head<2>();
    const std::optional<GroundPoint> ground = world_->ground(place);
    if (!ground) continue;
    lowest = std::min(lowest, ground->height);
    highest = std::max(highest, ground->height);
    if (corner.z() - ground->height < kRaised * size_) continue;
    const std::optional<Vec2> edge = world_->nearest_of_height(place, corner.z(), kAsHigh * size_);
    if (!edge || (*edge - place).norm() > kFeels * size_) continue;
    if (!way || (*edge - place).norm() < way->norm()) way = *edge - place;
  }
  if (way) return way;
  return highest - lowest > kRaised * size_ ? std::optional<Vec2>(Vec2::Zero()) : std::nullopt;
}

}  // namespace baton
