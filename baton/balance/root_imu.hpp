/// IMU readings, transformed to the root: the body with the free joint, to which the sensor is fixed.
#pragma once

#include "baton/balance/measurement.hpp"

namespace baton {

class RootImu {
 public:
  /// @param sensor pose of the sensor in the root frame
  /// @param yaw yaw of the root at the first reading [rad], as an IMU cannot measure it absolutely
  /// @param period time between readings [s]
  RootImu(const Pose& sensor, double yaw, double period);

  /// Motion of the root.
  struct RootMotion {
    Mat3 R = Mat3::Identity();          ///< attitude in the world
    Vec3 rate = Vec3::Zero();           ///< angular velocity, in the root frame [rad/s]
    Vec3 angular_accel = Vec3::Zero();  ///< in the world [rad/s²]; zero at the first reading
    Vec3 acceleration = Vec3::Zero();   ///< of the root's origin, in the world, gravity removed [m/s²]
  };

  [[nodiscard]] RootMotion update(const Measurement::Imu& imu);

 private:
  Pose sensor_;
  double start_yaw_;
  double period_;
  bool first_ = true;
  Mat3 yaw_offset_ = Mat3::Identity();  ///< rotation from the sensor's world frame to ours
  Vec3 previous_rate_ = Vec3::Zero();   ///< previous angular velocity, in the world [rad/s]
};

}  // namespace baton
