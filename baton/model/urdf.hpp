/// URDF files, made readable for MuJoCo.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "baton/model/mujoco.hpp"

namespace baton {

/// Whether the file's name ends in `.urdf`.
[[nodiscard]] bool is_urdf(const std::filesystem::path& file);

/// Reads a URDF file. `package://name/…` is looked for in the folder `name` beside the file or above it, in
/// `share/name` there, and in the folders of $ROS_PACKAGE_PATH; Collada meshes (`.dae`) are read, others left to
/// MuJoCo.
/// @throws InputError no such file; not a URDF; a mesh that is nowhere
[[nodiscard]] SpecPtr parse_urdf(const std::filesystem::path& file);

/// The joints' speed limits that a URDF states, by name [rad/s].
/// @throws InputError as above
[[nodiscard]] std::map<std::string, double> urdf_speed_limits(const std::filesystem::path& file);

}  // namespace baton
