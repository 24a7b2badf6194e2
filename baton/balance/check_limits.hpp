/// Limits that the checks of all sensors share.
#pragma once

#include "baton/math/pose.hpp"

namespace baton::check {

/// Whether a matrix is a rotation, within the errors of a sensor.
inline bool is_rotation(const Mat3& R) {
  return R.allFinite() && (R * R.transpose() - Mat3::Identity()).norm() < 1e-3 && R.determinant() > 0.0;
}

inline constexpr double kMoves = 0.1;    ///< planned speed from which readings change: norm over the joints [rad/s]
inline constexpr double kSame = 0.02;    ///< longest time between two readings of a slow sensor [s]
inline constexpr double kMemory = 0.05;  ///< time constant with which contradictions add up [s]

/// How far beyond its range a joint may be measured: zero errors, play [rad].
inline constexpr double kBeyondRange = 0.3;

}  // namespace baton::check
