/// Constant errors of a robot's sensors (docs/calibration.md).
#pragma once

#include <filesystem>
#include <string>

#include "baton/balance/measurement.hpp"
#include "baton/model/robot_model.hpp"

namespace baton {

struct Calibration {
  VecX encoder_zero;                    ///< what the encoders read at the model's zero angles (n) [rad]
  Vec2 imu_mount = Vec2::Zero();        ///< rotation vector's x, y of the IMU in its model's frame [rad]
  BySide<double> force_gain{1.0, 1.0};  ///< of the wrench read of each sole
  BySide<Vec3> force_zero{Vec3::Zero(), Vec3::Zero()};  ///< read where there is no force, in the sole frame [N]

  bool operator==(const Calibration&) const = default;

  /// No errors.
  [[nodiscard]] static Calibration none(int joints);

  /// Reads a file as `text_of` makes it.
  /// @throws InputError file missing or not TOML; key missing, unknown or out of range; another robot
  [[nodiscard]] static Calibration load(const std::filesystem::path& file, const RobotModel& robot);
};

/// A measurement as exact sensors make it → as sensors with these errors do. Times, speeds and torques stay.
[[nodiscard]] Measurement with_errors(Measurement measurement, const Calibration& errors);

/// The inverse.
[[nodiscard]] Measurement without_errors(Measurement measurement, const Calibration& errors);

/// The calibration as TOML text: angles in degrees, forces in newtons.
/// @param sigma standard deviation of each number, and before the calibration: for comments
[[nodiscard]] std::string text_of(const Calibration& calibration, const Calibration& sigma, const Calibration& prior,
                                  const RobotModel& robot);

/// Whether a calibration told little about a quantity: its standard deviation is nearly what it was before.
[[nodiscard]] constexpr bool poorly_observable(double sigma, double prior) {
  return sigma > 0.7 * prior;
}

}  // namespace baton
