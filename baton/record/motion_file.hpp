/// A motion in a file, to be verified again by whoever doubts it (docs/plan.md has the format).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// What a motion file says besides the motion.
struct MotionPlace {
  std::string robot;  ///< as for `--robot`
  std::string world;  ///< as for `--world`
  Pose anchor;        ///< planning frame in the world
};

[[nodiscard]] nlohmann::json motion_file(const Motion& motion, const MotionPlace& place);

/// Where a motion belongs.
/// @throws InputError no such file, not JSON, a key missing or of the wrong kind
[[nodiscard]] MotionPlace read_motion_place(const std::filesystem::path& file);

/// The motion as it is to be verified: its joint paths with their differences, soles, COM and contact phases.
/// @throws InputError as above, or made for another robot
[[nodiscard]] Motion read_motion(const std::filesystem::path& file, const RobotModel& robot);

}  // namespace baton
