/// What is read of the messages of a Unitree G1.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "baton/model/error.hpp"
#include "bridge/unitree/joints.hpp"
#include "bridge/unitree/reading.hpp"
#include "bridge/unitree/remote.hpp"
#include "tests/bridge/g1_like.hpp"
#include "tests/bridge/unitree_states.hpp"
#include "tests/support/robots.hpp"

namespace baton::unitree {
namespace {

using test::g1_like;
using testing::HasSubstr;

/// CRC-32/MPEG-2, bit by bit.
std::uint32_t by_bits(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const std::uint8_t byte : bytes) {
    for (int bit = 7; bit >= 0; --bit) {
      const bool one = ((crc >> 31U) ^ (byte >> bit & 1U)) != 0;
      crc = crc << 1U ^ (one ? 0x04c11db7U : 0U);
    }
  }
  return crc;
}

TEST(UnitreeChecksum, IsThePublishedOneOverWordsFromTheirHighestByteOn) {
  const std::string digits = "123456789";
  ASSERT_EQ(by_bits({digits.begin(), digits.end()}), 0x0376e6e7U) << "the published check value of CRC-32/MPEG-2";
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint8_t> bytes(4 * std::uniform_int_distribution<std::size_t>(0, 600)(random));
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    std::vector<std::uint8_t> turned;
    for (std::size_t word = 0; word < bytes.size(); word += 4) {
      for (std::size_t at = 4; at-- > 0;)
        turned.push_back(bytes[word + at]);
    }
    ASSERT_EQ(crc_of(std::as_bytes(std::span(bytes))), by_bits(turned));
  }
}

TEST(UnitreeChecksum, AnyFlippedBitOfAStateIsFound) {
  Random random(2);
  const LowState state = state_at(random, 7);
  ASSERT_FALSE(doubt(state));
  for (std::size_t bit = 0; bit < 8 * sizeof(state); bit += 1 + random() % 3) {
    std::array<unsigned char, sizeof(state)> bytes{};
    std::memcpy(bytes.data(), &state, sizeof(state));
    bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
    LowState flipped;
    std::memcpy(static_cast<void*>(&flipped), bytes.data(), sizeof(flipped));
    ASSERT_EQ(doubt(flipped), "wrong checksum") << bit;
  }
}

TEST(UnitreeJoints, EachMotorMovesTheJointOfItsName) {
  const std::vector<std::size_t> motors = motors_of(g1_like());
  ASSERT_EQ(motors.size(), kJoints.size());
  EXPECT_EQ(std::set<std::size_t>(motors.begin(), motors.end()).size(), kJoints.size());
  EXPECT_FALSE(std::is_sorted(motors.begin(), motors.end())) << "the model's order must be another, to tell anything";
  for (std::size_t i = 0; i < motors.size(); ++i)
    EXPECT_EQ(kJoints[motors[i]], g1_like().joints()[i].name);
  EXPECT_EQ(kJoints[4], "left_ankle_pitch_joint");  // as published
  EXPECT_EQ(kJoints[12], "waist_yaw_joint");
  EXPECT_EQ(kJoints[28], "right_wrist_yaw_joint");
}

TEST(UnitreeJoints, AnotherRobotIsRefused) {
  try {
    static_cast<void>(motors_of(test::robot("mighty")));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--robot mighty: a G1 has no joint 'left_shoulder_flexion'"));
  }
}

TEST(UnitreeReading, IsWhatTheStateSays) {
  Random random(3);
  const std::vector<std::size_t> motors = motors_of(g1_like());
  for (int i = 0; i < 2000; ++i) {
    const LowState state = state_at(random, 1);
    const Measurement measured = measurement_of(state, motors, 1.5);
    EXPECT_EQ(measured.t, 1.5);
    for (std::size_t joint = 0; joint < motors.size(); ++joint) {
      const auto at = static_cast<Eigen::Index>(joint);
      ASSERT_EQ(measured.q[at], state.motors[motors[joint]].q);
      ASSERT_EQ(measured.dq[at], state.motors[motors[joint]].dq);
      ASSERT_EQ(measured.torque[at], state.motors[motors[joint]].tau_est);
    }
    // docs/protocol.md
    const auto [w, x, y, z] = std::array<double, 4>{state.imu.quaternion[0], state.imu.quaternion[1],
                                                    state.imu.quaternion[2], state.imu.quaternion[3]};
    Mat3 attitude;
    attitude << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),          //
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
    ASSERT_TRUE(measured.imu.attitude.isApprox(attitude, 1e-6));
    ASSERT_EQ(measured.imu.rate[2], state.imu.gyroscope[2]);
    ASSERT_EQ(measured.imu.acceleration[2], state.imu.accelerometer[2]);
    ASSERT_TRUE(measured.sole[Side::left].force.array().isNaN().all());
  }
}

TEST(UnitreeReading, WhatNoSensorGivesIsDoubted) {
  Random random(4);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 5000; ++i) {
    LowState state = state_at(random, 1);
    const float bad = std::array{kNan, kInfinite, -kInfinite, 1e6F}[random() % 4];
    MotorState& motor = state.motors[random() % kJoints.size()];
    float* const any[] = {&motor.q,
                          &motor.dq,
                          &motor.tau_est,
                          &state.imu.quaternion[random() % 4],
                          &state.imu.gyroscope[random() % 3],
                          &state.imu.accelerometer[random() % 3]};
    *any[random() % std::size(any)] = bad;
    seal(state);
    ASSERT_THAT(doubt(state).value_or(""), HasSubstr("impossible"));
  }
  LowState state = state_at(random, 1);
  state.motors[30].q = kNan;  // there is no such motor
  seal(state);
  EXPECT_FALSE(doubt(state));
  state.imu.quaternion = {};
  seal(state);
  EXPECT_TRUE(doubt(state));
}

TEST(UnitreeReading, NamesTheMotorThatReportsAFault) {
  Random random(7);
  constexpr std::uint32_t kNoFaults = 0xfffe0000;  // calibration mode, version, nobody talks to it
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    for (std::size_t motor = 0; motor < kSlots; ++motor) {
      LowState state = state_at(random, 1);
      ASSERT_EQ(fault_of(state), "");
      state.motors[motor].motorstate = 1U << bit;
      const std::string fault = fault_of(state);
      if (motor >= kJoints.size() || ((1U << bit) & kNoFaults) == 1U << bit || bit == 16) {
        ASSERT_EQ(fault, "") << bit << " of " << motor;
      } else {
        ASSERT_THAT(
            fault, AllOf(HasSubstr(std::string(kJoints[motor]) + ": "), HasSubstr(fmt::format("(0x{:x})", 1U << bit))));
      }
    }
  }
}

TEST(UnitreeRemote, DampsWithEitherPairOfButtonsWhateverElseIsPressed) {
  for (unsigned buttons = 0; buttons < 1U << 16U; ++buttons) {
    std::array<std::uint8_t, 40> bytes{};
    bytes[2] = static_cast<std::uint8_t>(buttons);
    bytes[3] = static_cast<std::uint8_t>(buttons >> 8U);
    const Remote remote = remote_of(bytes);
    ASSERT_EQ(remote.damp,
              ((buttons & kL1) != 0 && (buttons & kA) != 0) || ((buttons & kL2) != 0 && (buttons & kB) != 0));
    ASSERT_EQ(remote.stance, (buttons & kStart) != 0);
    ASSERT_EQ(remote.on, buttons != 0);
  }
}

}  // namespace
}  // namespace baton::unitree
