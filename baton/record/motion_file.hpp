/// Motion files, for `baton verify` (format in docs/plan.md).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Context of a motion: robot, world and planning frame.
struct MotionPlace {
  std::string robot;  ///< as for `--robot`
  std::string world;  ///< as for `--world`
  Pose anchor;        ///< planning frame in the world frame
};

[[nodiscard]] nlohmann::json motion_file(const Motion& motion, const MotionPlace& place);

/// Reads the context of a motion.
/// @throws InputError the file is missing or not JSON; a key is missing or of the wrong type
[[nodiscard]] MotionPlace read_motion_place(const std::filesystem::path& file);

/// Reads the motion for verification: joint paths and their finite differences, soles, COM and contact phases.
/// @throws InputError as above, or the motion belongs to another robot
[[nodiscard]] Motion read_motion(const std::filesystem::path& file, const RobotModel& robot);

}  // namespace baton
