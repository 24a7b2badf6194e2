/// Complementary filter for roll and pitch of an IMU (after Mahony et al., IEEE Trans. Autom. Control 53(5), 2008):
/// integrates the gyro, and follows slowly the sensor's attitude and the direction of gravity. The yaw is the sensor's,
/// less its drift.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class AttitudeFilter {
 public:
  /// @param imu_in_root pose of the sensor in the root frame
  /// @param period of the measurements [s]
  /// @param omega of the linear inverted pendulum; the filter's rates scale with it [1/s]
  AttitudeFilter(const Pose& imu_in_root, double period, double omega);

  /// Attitude of the sensor in its world frame. Call once a tick.
  /// @param imu believed reading
  /// @param planned sample of this tick: its acceleration is subtracted from the specific force
  [[nodiscard]] const Mat3& update(const Measurement::Imu& imu, const MotionSample& planned);

  /// Sets the error of the sensor's yaw, which is subtracted from now on [rad].
  void set_yaw_error(double error) { yaw_error_ = error; }

 private:
  Mat3 root_in_imu_;
  double period_;
  double rate_attitude_;  ///< at which roll and pitch follow the sensor's [1/s]
  double rate_gravity_;   ///< at which they follow the direction of gravity [1/s]
  Mat3 R_ = Mat3::Identity();
  Mat3 last_ = Mat3::Identity();  ///< the sensor's attitude one tick ago
  double yaw_error_ = 0.0;        ///< error of the sensor's yaw [rad]
  bool first_ = true;
};

}  // namespace baton
