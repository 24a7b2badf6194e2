/// What the IMU says, carried over to the root: the body with the free joint, which the sensor is fixed to.
#pragma once

#include "baton/balance/measurement.hpp"

namespace baton {

class RootImu {
 public:
  /// @param sensor in the root's frame
  /// @param yaw of the root at the first reading [rad]: a sensor does not know where the world's x axis is
  /// @param period of the readings [s]
  RootImu(const Pose& sensor, double yaw, double period);

  /// Of the root.
  struct Motion {
    Mat3 R = Mat3::Identity();          ///< attitude in the world
    Vec3 rate = Vec3::Zero();           ///< in its own frame [rad/s]
    Vec3 angular_accel = Vec3::Zero();  ///< in the world; zero at the first reading [rad/s²]
    Vec3 acceleration = Vec3::Zero();   ///< of its origin, in the world, without gravity [m/s²]
  };

  [[nodiscard]] Motion update(const Measurement::Imu& imu);

 private:
  Pose sensor_;
  double start_yaw_;
  double period_;
  bool first_ = true;
  Mat3 yaw_ = Mat3::Identity();  ///< of the world in the sensor's world
  Vec3 rate_ = Vec3::Zero();     ///< a tick ago, in the world [rad/s]
};

}  // namespace baton
