/// A compiled model as a generic scene that a browser can draw: bodies, their visible geoms, meshes, places.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "baton/model/robot_model.hpp"

namespace baton {

/// The document of /model.json (docs/page.md). `scene` is the world composed with the robot; `world` its
/// name.
[[nodiscard]] nlohmann::json scene_document(const RobotModel& robot, const std::string& world, const mjModel& scene);

/// Base64 of a block of memory.
[[nodiscard]] std::string base64(const void* data, std::size_t size);

}  // namespace baton
