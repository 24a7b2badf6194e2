/// A robot whose sensors agree that it has been turned, or leans.
#pragma once

#include <algorithm>

#include "baton/balance/measurement.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::test {

/// Turns the sensor about its origin: the attitude, and with it the axes of the specific force.
/// @param turn rotation in the sensor's world frame
inline void turn_imu(Measurement& m, const Mat3& turn) {
  const Vec3 acceleration = m.imu.attitude * m.imu.acceleration;
  m.imu.attitude = turn * m.imu.attitude;
  m.imu.acceleration = m.imu.attitude.transpose() * acceleration;
}

/// Leans the robot forward over its ankles: encoders, attitude, gyro and specific force agree.
class Lean {
 public:
  /// The robot must outlive the object.
  explicit Lean(const RobotModel& robot) : robot_(&robot) {}

  /// Leans farther towards `angle` [rad], once a tick.
  /// @param speed [rad/s]
  void apply(Measurement& m, double angle, double speed = 0.25) {
    const double period = robot_->profile().tick.period;
    const double step = std::clamp(angle - angle_, -speed * period, speed * period);
    angle_ += step;
    if (angle_ == 0.0 && step == 0.0) return;
    for (const Side side : kSides)
      m.q[robot_->leg(side)[robot_->leg(side).size() - 2]] += angle_;
    turn_imu(m, rotation_exp(Vec3(0.0, angle_, 0.0)));
    m.imu.rate += m.imu.attitude.transpose() * Vec3(0.0, step / period, 0.0);
  }

  [[nodiscard]] double angle() const { return angle_; }  ///< [rad]

 private:
  const RobotModel* robot_;
  double angle_ = 0.0;
};

}  // namespace baton::test
