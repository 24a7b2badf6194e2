/// Attitude of an IMU that has a gyro and an accelerometer alone.
#pragma once

#include "baton/math/pose.hpp"

namespace baton::bridge {

/// Integrates the gyro, and follows slowly the direction of gravity (Mahony et al., IEEE Trans. Autom. Control 53(5),
/// 2008). Its yaw begins at zero and drifts.
class ImuAttitude {
 public:
  /// @param period of the readings [s]
  explicit ImuAttitude(double period) : period_(period) {}

  /// Begins from rest.
  /// @param force mean specific force, in the sensor's axes [m/s²]; not zero
  void start(const Vec3& force);
  /// Call it once for each reading.
  /// @param rate angular velocity in the sensor's axes [rad/s]
  /// @param force specific force there [m/s²]
  void update(const Vec3& rate, const Vec3& force);

  /// Of the sensor, in a frame whose z points up.
  [[nodiscard]] const Mat3& attitude() const { return R_; }

 private:
  double period_;
  Vec3 last_rate_ = Vec3::Zero();  ///< [rad/s]
  Mat3 R_ = Mat3::Identity();
};

}  // namespace baton::bridge
