#include "baton/navigate/drift.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kShare = 0.05;  ///< of the trunk's reach that a motion corrects

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

}  // namespace baton
