/// Sensor readings of a robot.
#pragma once

#include <optional>

#include "baton/model/contact.hpp"

namespace baton {

/// Pose and velocity of the root, the body with the free joint. Only a simulated robot can measure it.
struct RootMeasurement {
  Pose pose;                     ///< in the world
  Vec3 velocity = Vec3::Zero();  ///< of the origin, in the world [m/s]
  Vec3 rate = Vec3::Zero();      ///< angular velocity, in the root frame [rad/s]
};

struct Measurement {
  double t = 0.0;    ///< when the sensors were read [s]
  double age = 0.0;  ///< time from then until now, by the robot's clock [s]
  VecX q;            ///< joint angles (n) [rad]
  VecX dq;           ///< joint speeds (n) [rad/s]
  VecX torque;       ///< motor torques by their currents (n) [N·m]; empty: not measured
  struct Imu {
    Mat3 attitude = Mat3::Identity();  ///< of the sensor in its world frame, whose yaw is arbitrary
    Vec3 rate = Vec3::Zero();          ///< angular velocity, in the sensor frame [rad/s]
    Vec3 acceleration = Vec3::Zero();  ///< specific force, in the sensor frame [m/s²]

    bool operator==(const Imu&) const = default;
  } imu;
  BySide<Wrench> sole;  ///< contact wrench on each sole, in the sole frame, moment about its centre
  std::optional<RootMeasurement> root;
};

}  // namespace baton
