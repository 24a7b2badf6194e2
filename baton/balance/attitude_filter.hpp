/// Attitude of the IMU from three sources: its gyro over short times, and its own attitude and the direction of gravity
/// over longer ones (complementary filter, after Mahony et al., IEEE Trans. Autom. Control 53(5), 2008). The yaw is the
/// sensor's.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class AttitudeFilter {
 public:
  /// @param imu_in_root pose of the sensor in the root frame
  /// @param period of the measurements [s]
  /// @param omega rate of the robot's pendulum, which scales the filter's [1/s]
  AttitudeFilter(const Pose& imu_in_root, double period, double omega);

  /// Attitude of the sensor in its world frame, after this reading.
  /// @param imu believed reading
  /// @param planned sample of this tick: its acceleration is subtracted from the specific force
  [[nodiscard]] const Mat3& update(const Measurement::Imu& imu, const MotionSample& planned);

  /// Takes a drift of the yaw out, from here on [rad/s].
  void set_yaw_drift(double rate) { yaw_drift_ = rate; }

 private:
  Mat3 root_in_imu_;
  double period_;
  double rate_attitude_;  ///< at which roll and pitch follow the sensor's [1/s]
  double rate_gravity_;   ///< at which they follow the direction of gravity [1/s]
  Mat3 R_ = Mat3::Identity();
  double yaw_drift_ = 0.0;  ///< [rad/s]
  double drifted_ = 0.0;    ///< yaw that was taken out so far [rad]
  bool first_ = true;
};

}  // namespace baton
