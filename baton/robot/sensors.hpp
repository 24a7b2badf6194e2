/// Errors of a simulated robot's sensors: an exact measurement → what they say.
#pragma once

#include <cstdint>
#include <random>

#include "baton/balance/measurement.hpp"

namespace baton {

/// How wrong a robot's sensors are.
struct SensorErrors {
  double encoder_noise = 0.0;    ///< standard deviation of an angle, at each reading [rad]
  double force_noise = 0.0;      ///< of each component of the soles' wrenches, share of its value
  Vec3 imu_bias = Vec3::Zero();  ///< rotation vector by which its attitude is off, in the world [rad]
};

class Sensors {
 public:
  /// @param joints their number
  /// @param period of the measurements [s]
  /// @param seed of the noise
  Sensors(const SensorErrors& errors, int joints, double period, std::uint64_t seed);

  /// What a joint's encoder says to its servo, each time that it is read [rad].
  [[nodiscard]] double encoder(double angle);

  /// Puts the errors of one tick into an exact measurement. Joint speeds are differences of angles over a tick, and so
  /// have the noise of both.
  void disturb(Measurement& measurement);

 private:
  [[nodiscard]] double noise() { return normal_(random_); }

  SensorErrors errors_;
  double period_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  VecX encoder_error_;  ///< of the last measurement [rad]
};

}  // namespace baton
