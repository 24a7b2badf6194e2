/// The two messages of a Unitree G1's low level (unitree_hg), as they lie in memory and under their checksum: the sizes
/// and the order of the members are the maker's. What the compiler would leave as gaps is named `gap` here, and zero,
/// as the checksum covers it.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace baton::unitree {

static_assert(std::endian::native == std::endian::little, "the checksum is over little-endian words");

inline constexpr std::size_t kSlots = 35;  ///< for motors in each message; a G1 has the first 29

/// A motor's torque is kp (q − measured) + kd (dq − measured) + tau.
struct MotorCommand {
  std::uint8_t mode = 0;  ///< 1: on
  std::array<std::uint8_t, 3> gap{};
  float q = 0.0F;    ///< [rad]
  float dq = 0.0F;   ///< [rad/s]
  float tau = 0.0F;  ///< [N·m]
  float kp = 0.0F;   ///< [N·m/rad]
  float kd = 0.0F;   ///< [N·m·s/rad]
  std::uint32_t reserve = 0;
};

/// rt/lowcmd: to the robot.
struct LowCommand {
  std::uint8_t mode_pr = 0;       ///< ankles and waist by pitch and roll (0), or by their motors A and B (1)
  std::uint8_t mode_machine = 0;  ///< kind of robot: as in its states, or it does not listen
  std::array<std::uint8_t, 2> gap{};
  std::array<MotorCommand, kSlots> motors{};
  std::array<std::uint32_t, 4> reserve{};
  std::uint32_t crc = 0;  ///< checksum of all before
};

struct ImuState {
  std::array<float, 4> quaternion{};     ///< w, x, y, z
  std::array<float, 3> gyroscope{};      ///< [rad/s]
  std::array<float, 3> accelerometer{};  ///< specific force [m/s²]
  std::array<float, 3> rpy{};            ///< [rad]
  std::int16_t temperature = 0;          ///< [°C]
  std::array<std::uint8_t, 2> gap{};
};

struct MotorState {
  std::uint8_t mode = 0;
  std::array<std::uint8_t, 3> gap{};
  float q = 0.0F;        ///< [rad]
  float dq = 0.0F;       ///< [rad/s]
  float ddq = 0.0F;      ///< [rad/s²]
  float tau_est = 0.0F;  ///< [N·m]
  std::array<std::int16_t, 2> temperature{};
  float vol = 0.0F;  ///< [V]
  std::array<std::uint32_t, 2> sensor{};
  std::uint32_t motorstate = 0;
  std::array<std::uint32_t, 4> reserve{};
};

/// rt/lowstate: from the robot.
struct LowState {
  std::array<std::uint32_t, 2> version{};
  std::uint8_t mode_pr = 0;
  std::uint8_t mode_machine = 0;  ///< 4: 23 joints, 5: 29, 6: 27, with the waist locked
  std::array<std::uint8_t, 2> gap{};
  std::uint32_t tick = 0;  ///< [ms]
  ImuState imu;
  std::array<MotorState, kSlots> motors{};
  std::array<std::uint8_t, 40> wireless_remote{};
  std::array<std::uint32_t, 4> reserve{};
  std::uint32_t crc = 0;  ///< checksum of all before
};

static_assert(sizeof(LowCommand) == 1004 && sizeof(LowState) == 2092);

/// CRC-32 (polynomial 04c11db7, start ffffffff, nothing reflected, nothing added at the end) over whole words, the most
/// significant bit of each first.
/// @param bytes a multiple of 4; the rest is left out
[[nodiscard]] std::uint32_t crc_of(std::span<const std::byte> bytes);

/// What `crc` of a message must be.
template <typename Message>
[[nodiscard]] std::uint32_t checksum(const Message& message) {
  static_assert(offsetof(Message, crc) + sizeof(message.crc) == sizeof(Message));
  return crc_of(std::as_bytes(std::span(&message, 1)).first(offsetof(Message, crc)));
}

}  // namespace baton::unitree
