/// An IMU whose readings agree that it has been turned.
#pragma once

#include "baton/balance/measurement.hpp"

namespace baton::test {

/// Turns the sensor about its origin: the attitude, and with it the axes of the specific force.
/// @param turn rotation in the sensor's world frame
inline void turn_imu(Measurement& m, const Mat3& turn) {
  const Vec3 acceleration = m.imu.attitude * m.imu.acceleration;
  m.imu.attitude = turn * m.imu.attitude;
  m.imu.acceleration = m.imu.attitude.transpose() * acceleration;
}

}  // namespace baton::test
