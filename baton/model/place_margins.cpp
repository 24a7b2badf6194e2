#include "baton/model/place_margins.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kAtEdges = 0.1;       ///< share of the uncertainty that counts at edges
constexpr double kEdgeShare = 0.7;     ///< share of the room beside an edge that uncertainty may take
constexpr double kFromObstacle = 0.1;  ///< largest part for uncertainty [COM height]

}  // namespace

double edge_margin(const RobotModel& robot, double uncertainty) {
  const Profile& profile = robot.profile();
  double toe = 0.0;
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    toe = std::max(toe, vertex.x());
  // What the longest step past an edge leaves on each side of it, beside the margin to edges.
  const double room = std::max(0.0, 0.5 * (profile.region.foot_x.hi - 2.0 * toe) - profile.margin.edge);
  return profile.margin.edge + std::min(kAtEdges * uncertainty, kEdgeShare * room);
}

double obstacle_uncertainty(const RobotModel& robot, double uncertainty) {
  return std::min(uncertainty, kFromObstacle * robot.profile().stance.com_height);
}

}  // namespace baton
