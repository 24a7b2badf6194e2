/// Which motor of a G1 moves which joint.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton::unitree {

/// The joints in the order of the motors in messages.
inline constexpr std::array<std::string_view, 29> kJoints{
    "left_hip_pitch_joint",     "left_hip_roll_joint",     "left_hip_yaw_joint",         "left_knee_joint",
    "left_ankle_pitch_joint",   "left_ankle_roll_joint",   "right_hip_pitch_joint",      "right_hip_roll_joint",
    "right_hip_yaw_joint",      "right_knee_joint",        "right_ankle_pitch_joint",    "right_ankle_roll_joint",
    "waist_yaw_joint",          "waist_roll_joint",        "waist_pitch_joint",          "left_shoulder_pitch_joint",
    "left_shoulder_roll_joint", "left_shoulder_yaw_joint", "left_elbow_joint",           "left_wrist_roll_joint",
    "left_wrist_pitch_joint",   "left_wrist_yaw_joint",    "right_shoulder_pitch_joint", "right_shoulder_roll_joint",
    "right_shoulder_yaw_joint", "right_elbow_joint",       "right_wrist_roll_joint",     "right_wrist_pitch_joint",
    "right_wrist_yaw_joint"};

/// Motor of each joint of a model.
/// @throws InputError the model's joints are not those of a G1
[[nodiscard]] std::vector<std::size_t> motors_of(const RobotModel& model);

}  // namespace baton::unitree
