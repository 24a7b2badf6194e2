#include "baton/navigate/drift.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kShare = 0.05;     ///< of the trunk's reach that a motion corrects
constexpr double kBand = 0.006;     ///< displacement that is not corrected, as each step leaves some [COM height]
constexpr double kTurnBand = 3e-3;  ///< the same for the turn [rad]

}  // namespace

Pose drift_correction(const RobotModel& robot, const GuideContext& context, const Command& command) {
  const Vec3 led(command.axes[0], command.axes[1], command.axes[5]);
  if (command.guide != Part::trunk || command.recall != Recall::none || led.isZero(0.0)) return {};
  // The drift, seen from the COM.
  const Vec3& com = context.from.com;
  const Pose drift = context.anchor.inverse() * context.slip_free_frame;
  const Eigen::Rotation2Dd heading(context.from.heading());
  const Vec2 shift = heading.inverse() * (drift * com - com).head<2>();
  const Profile& profile = robot.profile();
  const double share = kShare * std::min(1.0, led.norm());
  const double most_turn = share * profile.reach.rotation;
  const Mat3 R = rotation_z(std::clamp(beyond(yaw_of(drift.R), kTurnBand), -most_turn, most_turn));
  const double most = share * profile.reach.trunk;
  Vec2 correction;
  for (const int axis : {0, 1})
    correction[axis] = std::clamp(beyond(shift[axis], kBand * profile.stance.com_height), -most, most);
  Vec3 p = com - R * com;
  p.head<2>() += heading * correction;
  return {p, R};
}

}  // namespace baton
