/// Plausibility of an IMU: attitude, gyro and accelerometer, against each other and against the plan.
#pragma once

#include <optional>

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class ImuCheck {
 public:
  /// @param imu_in_root pose of the sensor in the root frame
  /// @param period of the measurements [s]
  ImuCheck(const Pose& imu_in_root, double period) : in_root_(imu_in_root), period_(period) {}

  struct Accepted {
    bool attitude = true;
    bool gyro = true;
    bool accelerometer = true;
  };
  /// Judges a reading; what is rejected is predicted.
  ///
  /// - Gyro: in range, without jumps that the attitude does not show, and on average what the attitude shows.
  ///   Prediction: planned.
  /// - Attitude: a rotation, turned from the last one as the gyro says. Prediction: the last one, turned by the gyro.
  ///   If they go on contradicting each other, the one that agrees with the direction of gravity is believed.
  /// - Accelerometer: in range, and on average what gravity and the plan give. Prediction: that.
  ///
  /// @param planned sample of this tick
  Accepted check(const Measurement::Imu& imu, const MotionSample& planned);
  /// Moves everything as planned: nothing was measured.
  void predict(const MotionSample& planned);

  /// What is believed.
  [[nodiscard]] const Measurement::Imu& imu() const { return imu_; }

 private:
  /// @param turn since the last tick, by the attitude [rad]
  [[nodiscard]] bool gyro_accepted(const Vec3& rate, const Vec3& planned, const std::optional<Vec3>& turn);
  [[nodiscard]] bool accelerometer_accepted(const Vec3& acceleration, const Vec3& planned, bool moves);
  [[nodiscard]] bool attitude_accepted(const Mat3& attitude, const Mat3& predicted);
  /// Whether the specific force agrees at least as well with `attitude` as with `predicted`.
  [[nodiscard]] bool gravity_agrees(const Mat3& attitude, const Mat3& predicted, const MotionSample& planned) const;
  /// Specific force in the sensor frame, by plan, for this attitude of the sensor [m/s²].
  [[nodiscard]] Vec3 planned_force(const Mat3& attitude, const MotionSample& planned) const;
  /// Rotation from the planning frame to the sensor's world frame, about z.
  [[nodiscard]] Mat3 heading(const Mat3& attitude, const MotionSample& planned) const;

  Pose in_root_;
  double period_;
  Measurement::Imu last_;  ///< reading one tick ago
  Measurement::Imu imu_;   ///< believed
  struct {
    int attitude = 0;
    int gyro = 0;
    int accelerometer = 0;
  } same_;                              ///< ticks in a row with the same reading
  Vec3 excess_turn_ = Vec3::Zero();     ///< integral of gyro minus change of attitude, leaky [rad]
  Vec3 excess_speed_ = Vec3::Zero();    ///< integral of measured minus planned acceleration, leaky [m/s]
  Vec3 measured_force_ = Vec3::Zero();  ///< specific force, low-passed, in the sensor frame [m/s²]
  Vec3 planned_force_ = Vec3::Zero();   ///< the same by plan, in the planning frame [m/s²]
  Vec3 turned_ = Vec3::Zero();          ///< turn by the gyro since the attitude last changed [rad]
  Mat3 turn_ = Mat3::Identity();        ///< yaw by which accepted attitudes are turned, after a jump of the sensor's
  double contradicted_ = 0.0;           ///< time since the last accepted attitude [s]
  double blind_ = 0.0;                  ///< the part of it without gyro [s]
  bool valid_ = false;                  ///< whether the last attitude is a rotation
  bool first_ = true;
};

}  // namespace baton
