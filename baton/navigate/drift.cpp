#include "baton/navigate/drift.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kShare = 0.05;     ///< of the trunk's reach that a motion corrects
constexpr double kBand = 0.006;     ///< displacement that is not corrected, as each step leaves some [COM height]
constexpr double kTurnBand = 3e-3;  ///< the same for the turn [rad]

/// What a value exceeds a band by, and at most `most`.
double beyond(double value, double band, double most) {
  return std::clamp(value - std::clamp(value, -band, band), -most, most);
}

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
  const Mat3 R = rotation_z(beyond(yaw_of(drift.R), kTurnBand, share * profile.reach.rotation));
  const double band = kBand * profile.stance.com_height;
  const double most = share * profile.reach.trunk;
  Vec3 p = com - R * com;
  p.head<2>() += heading * Vec2(beyond(shift.x(), band, most), beyond(shift.y(), band, most));
  return {p, R};
}

}  // namespace baton
