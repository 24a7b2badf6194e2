/// Errors of a robot's sensors and actuators: what a simulated robot has in common with a real one (docs/balance.md).
#pragma once

#include "baton/math/pose.hpp"

namespace baton {

/// Sizes of the sensors' errors; the default is none. Constant errors are drawn from a seed, uniformly within their
/// bound.
struct SensorErrors {
  double delay = 0.0;                ///< least age of a measurement when it is read [s]
  double jitter = 0.0;               ///< its age varies by so much [s]
  double encoder_noise = 0.0;        ///< standard deviation of each reading [rad]
  double encoder_offset = 0.0;       ///< bound of each joint's zero error [rad]
  double encoder_step = 0.0;         ///< resolution; 0: exact [rad]
  bool differenced_speeds = false;   ///< joint speeds are differences of successive angles
  Vec3 imu_bias = Vec3::Zero();      ///< constant attitude error, a rotation vector in the world frame [rad]
  double imu_mount = 0.0;            ///< tilt of the sensor on its link, in a random direction [rad]
  double imu_wander = 0.0;           ///< standard deviation of roll and pitch errors that change within seconds [rad]
  double yaw_drift = 0.0;            ///< of attitude and gyro, to a random side [rad/s]
  double gyro_noise = 0.0;           ///< standard deviation [rad/s]
  double accelerometer_noise = 0.0;  ///< standard deviation [m/s²]
  double force_noise = 0.0;          ///< of each component of the sole wrenches, relative
  double force_gain = 0.0;           ///< bound of each sole's gain error, relative
  double force_zero = 0.0;           ///< bound of the zero error of each sole's forces [weight]
  double glitches = 0.0;             ///< longest interval between faults; 0: none [s]

  bool operator==(const SensorErrors&) const = default;
};

/// How the actuators deviate from motors and servos of the profile; the default is not at all.
struct ActuatorErrors {
  double gain = 1.0;                ///< factor on the commanded motor torque
  double strength = 1.0;            ///< factor on the stall torque
  double kp = 1.0;                  ///< factor on the servos' stiffness
  double delay = 0.0;               ///< between sending a joint target and its arrival at the servos [s]
  bool held_targets = false;        ///< servos jump to the target of a tick instead of moving there during the tick
  bool differenced_speeds = false;  ///< servos damp by differences of their encoder readings, not by the true speed
  double lag = 0.0;                 ///< time constant of the motor torque [s]
  double friction = 0.0;            ///< dry friction of a joint, share of its stall torque
  double backlash = 0.0;            ///< play of a joint to each side, between motor with encoder and link [rad]
  double hip_compliance = 0.0;      ///< yield of each leg's first abduction axis [rad per weight × COM height]

  bool operator==(const ActuatorErrors&) const = default;
};

}  // namespace baton
