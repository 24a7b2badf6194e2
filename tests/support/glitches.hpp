/// Sensor readings that no robot can have: for tests of what is believed.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string_view>
#include <vector>

#include "baton/balance/measurement.hpp"

namespace baton::test {

struct Glitch {
  std::string_view name;
  std::function<void(Measurement&, std::mt19937_64&)> spoil;
};

/// One of each kind; whoever applies them chooses when and for how long.
inline const std::vector<Glitch>& glitches() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const auto any = [](std::mt19937_64& random, Eigen::Index n) {
    return std::uniform_int_distribution<Eigen::Index>(0, n - 1)(random);
  };
  const auto axis = [](std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    return Vec3(normal(random), normal(random), normal(random)).normalized();
  };
  static const std::vector<Glitch> all{
      {"an angle is NaN", [=](Measurement& m, auto& r) { m.q[any(r, m.q.size())] = kNan; }},
      {"all angles are infinite", [=](Measurement& m, auto&) { m.q.setConstant(kInf); }},
      {"an angle jumps", [=](Measurement& m, auto& r) { m.q[any(r, m.q.size())] += 2.0; }},
      {"a speed is NaN", [=](Measurement& m, auto& r) { m.dq[any(r, m.dq.size())] = kNan; }},
      {"a speed is 100 rad/s", [=](Measurement& m, auto& r) { m.dq[any(r, m.dq.size())] = 100.0; }},
      {"all speeds are -1000 rad/s", [=](Measurement& m, auto&) { m.dq.setConstant(-1000.0); }},
      {"the attitude is NaN", [=](Measurement& m, auto&) { m.imu.attitude.setConstant(kNan); }},
      {"the attitude is zero", [=](Measurement& m, auto&) { m.imu.attitude.setZero(); }},
      {"the attitude is 0.9 rad off",
       [=](Measurement& m, auto& r) { m.imu.attitude = rotation_exp(0.9 * axis(r)) * m.imu.attitude; }},
      {"the gyro is NaN", [=](Measurement& m, auto&) { m.imu.rate.y() = kNan; }},
      {"the gyro reads 1000 rad/s", [=](Measurement& m, auto& r) { m.imu.rate = 1000.0 * axis(r); }},
      {"the gyro reads 30 rad/s", [=](Measurement& m, auto& r) { m.imu.rate = 30.0 * axis(r); }},
      {"the accelerometer is NaN", [=](Measurement& m, auto&) { m.imu.acceleration.z() = kNan; }},
      {"the accelerometer reads 1e6 m/s2", [=](Measurement& m, auto& r) { m.imu.acceleration = 1e6 * axis(r); }},
      {"a force is NaN", [=](Measurement& m, auto&) { m.sole.left.force.z() = kNan; }},
      {"a force is -1e5 N", [=](Measurement& m, auto&) { m.sole.right.force.z() = -1e5; }},
      {"a moment is infinite", [=](Measurement& m, auto&) { m.sole.left.moment.x() = kInf; }},
      {"a motor torque is NaN", [=](Measurement& m, auto& r) {
         if (m.torque.size() > 0) m.torque[any(r, m.torque.size())] = kNan;
       }}};
  return all;
}

}  // namespace baton::test
