/// The specific force that a plan makes an accelerometer feel.
#pragma once

#include "baton/motion/motion.hpp"

namespace baton {

/// Planned specific force of the root, in the planning frame [m/s²].
[[nodiscard]] inline Vec3 planned_specific_force(const MotionSample& planned) {
  return planned.ddq.head<3>() + Vec3(0, 0, kGravity);
}

/// Rotation about the vertical that turns the planned heading of the root to that of `root`.
/// @param root attitude of the root
[[nodiscard]] inline Mat3 heading_from_plan(const Mat3& root, const MotionSample& planned) {
  const Mat3 in_plan = Eigen::Quaterniond(planned.q[3], planned.q[4], planned.q[5], planned.q[6]).toRotationMatrix();
  return rotation_z(yaw_of(root) - yaw_of(in_plan));
}

}  // namespace baton
