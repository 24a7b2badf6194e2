/// Sensor errors of a simulated robot: exact measurement → disturbed measurement.
#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "baton/robot/glitches.hpp"

namespace baton {

/// Magnitudes of the sensor errors.
struct SensorErrors {
  double encoder_noise = 0.0;    ///< standard deviation of each reading [rad]
  double force_noise = 0.0;      ///< of each component of the sole wrenches, relative
  Vec3 imu_bias = Vec3::Zero();  ///< attitude error as a rotation vector in the world frame [rad]
  double glitches = 0.0;         ///< longest interval between faults; 0: none [s]
};

class Sensors {
 public:
  /// @param joints number of joints
  /// @param period of the measurements [s]
  /// @param seed of the noise
  Sensors(const SensorErrors& errors, int joints, double period, std::uint64_t seed);

  /// Encoder reading for the servo; each call draws new noise [rad].
  [[nodiscard]] double encoder(double angle);

  /// Adds one tick's errors to an exact measurement. Joint speeds are differences of angles over a tick, so they carry
  /// the noise of both readings.
  void disturb(Measurement& measurement);

 private:
  [[nodiscard]] double noise() { return normal_(random_); }

  SensorErrors errors_;
  double period_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  VecX encoder_error_;  ///< in the last measurement [rad]
  std::optional<Glitches> glitches_;
};

}  // namespace baton
