/// Plausibility of sensor readings: what is not finite, changes faster than the robot can move, does not change while
/// it moves, or contradicts other sensors is rejected and bridged by a prediction (docs/balance.md).
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "baton/balance/force_check.hpp"
#include "baton/balance/imu_check.hpp"
#include "baton/balance/state_source.hpp"

namespace baton {

enum class Sensor { encoders, torques, attitude, gyro, accelerometer, forces };
inline constexpr std::array kSensors{Sensor::encoders, Sensor::torques,       Sensor::attitude,
                                     Sensor::gyro,     Sensor::accelerometer, Sensor::forces};

/// One value for each sensor.
template <typename T>
struct BySensor {
  std::array<T, kSensors.size()> values{};
  [[nodiscard]] constexpr T& operator[](Sensor sensor) { return values[static_cast<std::size_t>(sensor)]; }
  [[nodiscard]] constexpr const T& operator[](Sensor sensor) const { return values[static_cast<std::size_t>(sensor)]; }
};

[[nodiscard]] constexpr std::string_view to_string(Sensor sensor) {
  constexpr std::array<std::string_view, kSensors.size()> names{"encoders", "torques",       "attitude",
                                                                "gyro",     "accelerometer", "forces"};
  return names[static_cast<std::size_t>(sensor)];
}

enum class Health {
  good,
  bridged,  ///< rejected: a prediction stands in for the reading
  lost,     ///< rejected for too long to predict: the robot comes to rest
};

[[nodiscard]] constexpr std::string_view to_string(Health health) {
  constexpr std::array<std::string_view, 3> names{"good", "bridged", "lost"};
  return names[static_cast<std::size_t>(health)];
}

class SensorCheck {
 public:
  /// The robot must outlive the object.
  /// @param source of the robot's state: sensors that are not used for it are not judged
  SensorCheck(const RobotModel& robot, StateSource source);

  /// The measurement, with rejected readings replaced by predictions. Always finite, but for the root of a simulated
  /// robot and for sensors that are not used. Called once a tick; allocates nothing after the first.
  ///
  /// A measurement that is the same as the one before, while the plan moves, is late: all of it is predicted.
  /// - Joint angles: at most 0.3 rad outside the range; a change that the speed explains; not constant while the plan
  ///   moves. Prediction: the last angle, moved at the planned speed. An angle that jumped is believed once it has been
  ///   steady for 0.3 s.
  /// - Joint speeds: finite, within the motor's speed, and on average the change of the angle. Prediction: planned.
  /// - IMU: `ImuCheck`. Forces and motor torques: `ForceCheck`. Prediction of these two: planned.
  ///
  /// @param planned sample of this tick
  [[nodiscard]] const Measurement& check(const Measurement& measurement, const MotionSample& planned);

  /// What `check` returned last.
  [[nodiscard]] const Measurement& believed() const { return checked_; }
  [[nodiscard]] Health health(Sensor sensor) const;
  /// Whether nothing was measured in this tick, as all readings are those of the tick before, and the plan moves.
  [[nodiscard]] bool frozen() const { return repeats_ > 0; }
  /// Whether any sensor is lost.
  [[nodiscard]] bool lost() const;

 private:
  /// Whether nothing was measured since the last tick.
  [[nodiscard]] bool repeats(const Measurement& measurement) const;
  /// Moves everything as planned.
  void predict(const MotionSample& planned);
  [[nodiscard]] bool check_joints(const Measurement& measurement, const MotionSample& planned);
  /// Counts ticks of rejection. Returns `accepted`.
  bool count(Sensor sensor, bool accepted);

  const RobotModel* robot_;
  double period_;
  BySensor<bool> used_;  ///< whether the state depends on the sensor
  ImuCheck imu_;
  ForceCheck forces_;
  Measurement last_;        ///< reading one tick ago
  Measurement checked_;     ///< believed
  BySensor<int> rejected_;  ///< ticks in a row
  int repeats_ = 0;         ///< ticks since something was measured
  struct JointCheck {
    int rejected = 0;      ///< ticks in a row
    double planned = 0.0;  ///< planned movement since the angle last changed [rad]
    double steady = 0.0;   ///< time without jumps of the angle, believed or not [s]
    double excess = 0.0;   ///< integral of speed minus change of angle, leaky [rad]
  };
  std::vector<JointCheck> joints_;
  bool first_ = true;
};

}  // namespace baton
