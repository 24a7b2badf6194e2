#include "baton/navigate/drift.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kShare = 0.05;     ///< of the trunk's reach that a motion corrects
constexpr double kUncertain = 0.7;  ///< share of the room beside an edge that uncertainty of the place may take

}  // namespace

Pose drift_correction(const RobotModel& robot, const GuideContext& context, const Command& command) {
  const Vec3 led(command.axes[0], command.axes[1], command.axes[5]);
  if (command.guide != Part::trunk || command.recall != Recall::none || led.isZero(0.0)) return {};
  // The drift, seen from the COM.
  const Vec3& com = context.from.com;
  const Pose drift = context.anchor.inverse() * context.slip_free_frame;
  const Vec2 shift = (drift * com - com).head<2>();
  const double turn = yaw_of(drift.R);
  if (shift.norm() < kInPlace * robot.profile().stance.com_height && std::abs(turn) < kInPlace) return {};
  const Profile::Reach& reach = robot.profile().reach;
  const double share = kShare * std::min(1.0, led.norm());
  const double most_turn = share * reach.rotation;
  const Mat3 R = rotation_z(std::clamp(turn, -most_turn, most_turn));
  Vec3 p = com - R * com;
  p.head<2>() += bounded(shift, share * reach.trunk);
  return {p, R};
}

double bounded_uncertainty(const RobotModel& robot, double uncertainty) {
  const Profile& profile = robot.profile();
  double toe = 0.0;
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    toe = std::max(toe, vertex.x());
  // What the longest step past an edge leaves on each side of it, beside the margin to edges.
  const double room = std::max(0.0, 0.5 * (profile.region.foot_x.hi - 2.0 * toe) - profile.margin.edge);
  return std::min(uncertainty, kUncertain * room);
}

}  // namespace baton
