/// What a state of the robot says, if it can be believed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "baton/balance/measurement.hpp"
#include "bridge/unitree/messages.hpp"

namespace baton::unitree {

/// @returns why a state cannot be the robot's own: its checksum, or a number that no sensor gives; none: it may be
[[nodiscard]] std::optional<std::string> doubt(const LowState& state);

/// What a motor reports to be wrong with itself (`motorstate`): "left_knee_joint: winding too hot (0x200)"; "":
/// nothing. That no driver talks to it, and what concerns its calibration or version, is no fault. Bits as the maker's
/// documentation of the G1 has them.
[[nodiscard]] std::string fault_of(const LowState& state);

/// @param state without doubt
/// @param motors of each joint
/// @param t when it arrived [s]
/// @returns joints, motor torques as the robot estimates them, and the pelvis's IMU; no forces on the soles
[[nodiscard]] Measurement measurement_of(const LowState& state, const std::vector<std::size_t>& motors, double t);

}  // namespace baton::unitree
