/// Sensor errors of a simulated robot: exact measurement → disturbed measurement.
#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "baton/model/hardware_errors.hpp"
#include "baton/robot/glitches.hpp"

namespace baton {

class Sensors {
 public:
  /// @param joints number of joints
  /// @param period of the measurements [s]
  /// @param weight of the robot [N]
  /// @param seed of the noise and the constant errors
  Sensors(const SensorErrors& errors, int joints, double period, double weight, std::uint64_t seed);

  /// Encoder reading for the servo; each call draws new noise [rad].
  [[nodiscard]] double encoder(std::size_t joint, double angle);

  /// Time between taking the next measurement and its being read; each call draws a new one [s].
  [[nodiscard]] double age();

  /// Adds the errors to an exact measurement. With `encoder_noise` alone joint speeds carry the noise of this reading
  /// and the last one, as if differenced. The first measurement, at rest, has the exact speeds.
  void disturb(Measurement& measurement);

 private:
  /// Slowly varying error: a sum of sinusoids.
  struct Wander {
    static constexpr std::size_t kWaves = 4;
    std::array<double, kWaves> rate{};   ///< [rad/s]
    std::array<double, kWaves> phase{};  ///< [rad]

    /// Of standard deviation 1.
    [[nodiscard]] double at(double t) const;
  };

  [[nodiscard]] double noise() { return normal_(random_); }
  [[nodiscard]] Vec3 noise_vector(double deviation);
  [[nodiscard]] double quantised(double angle) const;
  void disturb_joints(Measurement& measurement);
  void disturb_imu(Measurement& measurement);
  void disturb_forces(Measurement& measurement);

  SensorErrors errors_;
  double period_;
  std::mt19937_64 random_;
  std::mt19937_64 jitter_;
  std::normal_distribution<double> normal_;
  VecX encoder_error_;   ///< noise in the last measurement [rad]
  VecX encoder_offset_;  ///< [rad]
  VecX last_angles_;     ///< as read; empty before the first measurement [rad]
  VecX last_speeds_;     ///< as read [rad/s]
  double last_time_ = 0.0;
  Mat3 mount_;  ///< attitude of the IMU on its link, against the model
  std::array<Wander, 2> wander_;
  double yaw_drift_ = 0.0;  ///< [rad/s]
  BySide<double> force_gain_{1.0, 1.0};
  BySide<Vec3> force_zero_{Vec3::Zero(), Vec3::Zero()};  ///< [N]
  std::optional<Glitches> glitches_;
};

}  // namespace baton
