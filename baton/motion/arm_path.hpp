/// How joints of the arms move in a motion when something outside the navigator drives them.
#pragma once

#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// A path in time that each joint leaves early enough to be at rest when the motion ends.
struct ArmPath {
  long version = 0;         ///< of the trajectory that it follows: `ArmTrajectory::version`
  std::vector<int> joints;  ///< indices of the joints
  double period = 0.0;      ///< from column to column, from the start of the motion [s]
  MatX q, dq, ddq;          ///< joints × columns [rad], [rad/s], [rad/s²]
  double braking = 0.0;     ///< time in which they brake [s]
  VecX until;               ///< when each brakes at the latest (joints) [s]
  double duration = 0.0;    ///< of a motion in which they come to their last target, or as far as is known [s]

  /// Angle of a joint in a motion that takes `T`. From the brake on, a quartic: position, speed and acceleration go on,
  /// and end at rest.
  /// @param row of the matrices
  [[nodiscard]] double at(Eigen::Index row, double t, double T) const;
  /// Whether nothing moves.
  [[nodiscard]] bool still() const { return dq.isZero(1e-9) && ddq.isZero(1e-9); }
};

}  // namespace baton
