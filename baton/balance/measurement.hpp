/// What a robot's sensors say.
#pragma once

#include <optional>

#include "baton/model/contact.hpp"

namespace baton {

/// Pose and velocity of the body with the free joint. No sensor gives it; a simulated robot may, as a perfect
/// sensor.
struct RootMeasurement {
  Pose pose;                     ///< in the world
  Vec3 velocity = Vec3::Zero();  ///< of its origin, in the world [m/s]
  Vec3 rate = Vec3::Zero();      ///< angular, in its own frame [rad/s]
};

struct Measurement {
  double t = 0.0;  ///< [s]
  VecX q;          ///< joint angles (n) [rad]
  VecX dq;         ///< [rad/s]
  VecX torque;     ///< that the motors give, as their currents say; empty: not measured (n) [N·m]
  struct Imu {
    Mat3 attitude = Mat3::Identity();  ///< of the sensor in the world
    Vec3 rate = Vec3::Zero();          ///< in the sensor's frame [rad/s]
    Vec3 acceleration = Vec3::Zero();  ///< specific force in the sensor's frame [m/s²]
  } imu;
  BySide<Wrench> sole;  ///< on each sole, in the sole's frame, moment about its centre
  std::optional<RootMeasurement> root;
};

}  // namespace baton
