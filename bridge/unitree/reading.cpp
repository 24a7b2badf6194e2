#include "bridge/unitree/reading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "bridge/unitree/joints.hpp"

namespace baton::unitree {
namespace {

// Beyond what a sensor of a G1 gives. Which readings within that are odd is the driver's to judge.
constexpr float kFarthest = 10.0F;    ///< angle of a joint [rad]
constexpr float kFastest = 100.0F;    ///< joint or body [rad/s]
constexpr float kStrongest = 500.0F;  ///< torque [N·m]
constexpr float kHardest = 500.0F;    ///< specific force [m/s²]
constexpr double kNorm = 0.02;        ///< of the quaternion, from 1

constexpr std::array<std::pair<std::uint32_t, std::string_view>, 16> kFaults{{
    {0x1, "overcurrent"},
    {0x2, "short overvoltage"},
    {0x4, "lasting overvoltage"},
    {0x8, "short undervoltage"},
    {0x10, "chip too hot"},
    {0x20, "power stage too hot or too cold"},
    {0x40, "implausible temperature of the power stage"},
    {0x80, "housing too hot or too cold"},
    {0x100, "implausible temperature of the housing"},
    {0x200, "winding too hot"},
    {0x400, "rotor encoder 1 fails"},
    {0x800, "rotor encoder 2 fails"},
    {0x1000, "output encoder fails"},
    {0x2000, "calibration data are damaged"},
    {0x4000, "it has restarted"},
    {0x8000, "it is locked"},
}};

/// False for NaN, too.
bool within(float value, float limit) {
  return std::abs(value) <= limit;
}

Eigen::Quaterniond attitude_of(const ImuState& imu) {
  return {imu.quaternion[0], imu.quaternion[1], imu.quaternion[2], imu.quaternion[3]};
}

}  // namespace

std::string fault_of(const LowState& state) {
  for (std::size_t i = 0; i < kJoints.size(); ++i) {
    for (const auto& [bit, what] : kFaults) {
      if ((state.motors[i].motorstate & bit) != 0) return fmt::format("{}: {} (0x{:x})", kJoints[i], what, bit);
    }
  }
  return "";
}

std::optional<std::string> doubt(const LowState& state) {
  if (state.crc != checksum(state)) return "wrong checksum";
  for (std::size_t i = 0; i < kJoints.size(); ++i) {
    const MotorState& motor = state.motors[i];
    if (!within(motor.q, kFarthest) || !within(motor.dq, kFastest) || !within(motor.tau_est, kStrongest))
      return "impossible reading of a motor";
  }
  const auto all_within = [](const std::array<float, 3>& values, float limit) {
    return std::ranges::all_of(values, [limit](float value) { return within(value, limit); });
  };
  if (!(std::abs(attitude_of(state.imu).norm() - 1.0) <= kNorm) || !all_within(state.imu.gyroscope, kFastest) ||
      !all_within(state.imu.accelerometer, kHardest))
    return "impossible reading of the IMU";
  return std::nullopt;
}

Measurement measurement_of(const LowState& state, const std::vector<std::size_t>& motors, double t) {
  const auto n = static_cast<Eigen::Index>(motors.size());
  Measurement measured;
  measured.t = t;
  measured.q.resize(n);
  measured.dq.resize(n);
  measured.torque.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const MotorState& motor = state.motors[motors[static_cast<std::size_t>(i)]];
    measured.q[i] = motor.q;
    measured.dq[i] = motor.dq;
    measured.torque[i] = motor.tau_est;
  }
  measured.imu.attitude = attitude_of(state.imu).normalized().toRotationMatrix();
  for (int axis = 0; axis < 3; ++axis) {
    measured.imu.rate[axis] = state.imu.gyroscope[static_cast<std::size_t>(axis)];
    measured.imu.acceleration[axis] = state.imu.accelerometer[static_cast<std::size_t>(axis)];
  }
  for (const Side side : kSides) {
    measured.sole[side].force.setConstant(std::numeric_limits<double>::quiet_NaN());
    measured.sole[side].moment.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return measured;
}

}  // namespace baton::unitree
