/// States of a Unitree G1, made up for tests.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <random>

#include "bridge/unitree/messages.hpp"

namespace baton::unitree {

using Random = std::mt19937_64;

// Bits of the remote's buttons.
inline constexpr unsigned kL1 = 1U << 1U, kStart = 1U << 2U, kL2 = 1U << 5U, kA = 1U << 8U, kB = 1U << 9U;

inline double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Gives a message its checksum.
template <typename Message>
void seal(Message& message) {
  message.crc = checksum(message);
}

/// A state that may be the robot's.
inline LowState state_at(Random& random, std::uint32_t tick) {
  LowState state;
  state.version = {1, 2};
  state.mode_machine = 5;
  state.tick = tick;
  for (MotorState& motor : state.motors) {
    motor.mode = 1;
    motor.q = static_cast<float>(between(random, -0.2, 0.2));
    motor.dq = static_cast<float>(between(random, -1.0, 1.0));
    motor.tau_est = static_cast<float>(between(random, -20.0, 20.0));
    motor.temperature = {30, 31};
  }
  const Eigen::Quaterniond attitude(
      Eigen::AngleAxisd(between(random, -0.5, 0.5), Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
  state.imu.quaternion = {static_cast<float>(attitude.w()), static_cast<float>(attitude.x()),
                          static_cast<float>(attitude.y()), static_cast<float>(attitude.z())};
  for (float& rate : state.imu.gyroscope)
    rate = static_cast<float>(between(random, -1.0, 1.0));
  state.imu.accelerometer = {0.1F, 0.2F, 9.8F};
  seal(state);
  return state;
}

/// Buttons of the remote in a state.
inline void press(LowState& state, unsigned buttons) {
  state.wireless_remote[0] = 0x55;
  state.wireless_remote[2] = static_cast<std::uint8_t>(buttons);
  state.wireless_remote[3] = static_cast<std::uint8_t>(buttons >> 8U);
  seal(state);
}

}  // namespace baton::unitree
