/// A compiled model as a scene for the browser: bodies, visible geoms, meshes, sites.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "baton/model/robot_model.hpp"

namespace baton {

/// The document /model.json (docs/page.md). `scene` is robot and world composed; `world` its name.
[[nodiscard]] nlohmann::json scene_document(const RobotModel& robot, const std::string& world, const mjModel& scene);

/// Base64 encoding of a memory block.
[[nodiscard]] std::string base64(const void* data, std::size_t size);

}  // namespace baton
