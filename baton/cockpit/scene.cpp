#include "baton/cockpit/scene.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "baton/motion/posture.hpp"

namespace baton {
namespace {

using nlohmann::json;

constexpr int kLastVisibleGroup = 2;  ///< MuJoCo draws groups 0 to 2 by default

template <typename T>
json numbers(const T* values, int count) {
  return std::vector<double>(values, values + count);
}

std::string_view type_name(int geom_type) {
  switch (geom_type) {
    case mjGEOM_PLANE:
      return "plane";
    case mjGEOM_SPHERE:
      return "sphere";
    case mjGEOM_CAPSULE:
      return "capsule";
    case mjGEOM_ELLIPSOID:
      return "ellipsoid";
    case mjGEOM_CYLINDER:
      return "cylinder";
    case mjGEOM_BOX:
      return "box";
    case mjGEOM_MESH:
      return "mesh";
    default:
      return "";  // height fields and distance fields are not drawn
  }
}

bool has_visual_geom(const mjModel& m, int body) {
  for (int g = m.body_geomadr[body]; g < m.body_geomadr[body] + m.body_geomnum[body]; ++g) {
    if (m.geom_group[g] <= kLastVisibleGroup) return true;
  }
  return false;
}

json bodies(const mjModel& m) {
  json list = json::array();
  for (int b = 0; b < m.nbody; ++b) {
    list.push_back({{"name", name_of(m, mjOBJ_BODY, b)}, {"parent", m.body_parentid[b]}});
  }
  return list;
}

/// Geoms in the visual groups; all geoms of a body without any.
json geoms(const mjModel& m) {
  json list = json::array();
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    const bool visible = m.geom_group[g] <= kLastVisibleGroup || !has_visual_geom(m, body);
    const std::string_view type = type_name(m.geom_type[g]);
    const int material = m.geom_matid[g];
    // A geom without a colour uses its material's, as in MuJoCo's renderer.
    const float* rgba = m.geom_rgba + 4 * g;
    const bool unset = rgba[0] == 0.5F && rgba[1] == 0.5F && rgba[2] == 0.5F && rgba[3] == 1.0F;
    if (material >= 0 && unset) rgba = m.mat_rgba + 4 * material;
    if (!visible || type.empty() || rgba[3] == 0.0F) continue;
    json geom{{"name", name_of(m, mjOBJ_GEOM, g)},
              {"body", body},
              {"type", type},
              {"size", numbers(m.geom_size + 3 * g, 3)},
              {"pos", numbers(m.geom_pos + 3 * g, 3)},
              {"quat", numbers(m.geom_quat + 4 * g, 4)},
              {"rgba", numbers(rgba, 4)},
              {"group", m.geom_group[g]},
              {"shine", material < 0 ? 0.2F : m.mat_shininess[material]}};
    if (m.geom_type[g] == mjGEOM_MESH) geom["mesh"] = m.geom_dataid[g];
    list.push_back(std::move(geom));
  }
  return list;
}

/// Vertices as float32 × 3, faces as int32 × 3, both little-endian in base64.
json meshes(const mjModel& m) {
  json list = json::array();
  for (int i = 0; i < m.nmesh; ++i) {
    const float* vertices = m.mesh_vert + 3 * m.mesh_vertadr[i];
    const int* faces = m.mesh_face + 3 * m.mesh_faceadr[i];
    list.push_back({{"name", name_of(m, mjOBJ_MESH, i)},
                    {"vertices", base64(vertices, sizeof(float) * 3 * static_cast<std::size_t>(m.mesh_vertnum[i]))},
                    {"faces", base64(faces, sizeof(int) * 3 * static_cast<std::size_t>(m.mesh_facenum[i]))}});
  }
  return list;
}

/// Sites of the world.
json sites(const mjModel& m) {
  json list = json::array();
  for (int s = 0; s < m.nsite; ++s) {
    if (m.site_bodyid[s] != 0) continue;
    list.push_back({{"name", name_of(m, mjOBJ_SITE, s)},
                    {"pos", numbers(m.site_pos + 3 * s, 3)},
                    {"quat", numbers(m.site_quat + 4 * s, 4)},
                    {"visible", m.site_group[s] <= kLastVisibleGroup}});
  }
  return list;
}

}  // namespace

std::string base64(const void* data, std::size_t size) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t left = size - i;
    const unsigned block = static_cast<unsigned>(bytes[i]) << 16 |
                           (left > 1 ? static_cast<unsigned>(bytes[i + 1]) << 8 : 0U) |
                           (left > 2 ? static_cast<unsigned>(bytes[i + 2]) : 0U);
    text += letters[block >> 18 & 63U];
    text += letters[block >> 12 & 63U];
    text += left > 1 ? letters[block >> 6 & 63U] : '=';
    text += left > 2 ? letters[block & 63U] : '=';
  }
  return text;
}

json scene_document(const RobotModel& robot, const std::string& world, const mjModel& scene) {
  const auto body = [&](int id) {
    return find_id(scene, mjOBJ_BODY, name_of(robot.mj(), mjOBJ_BODY, id), "scene of the page");
  };
  json parts = json::array();
  for (const Part part : kParts) {
    const int id = part == Part::trunk ? robot.trunk_body()
                   : is_foot(part)     ? robot.foot_body(side_of(part))
                                       : robot.hand_body(side_of(part));
    parts.push_back({{"name", to_string(part)}, {"body", body(id)}});
  }
  return {{"robot", robot.profile().name},
          {"world", world},
          {"size", robot.profile().stance.com_height},
          {"parts", parts},
          {"bodies", bodies(scene)},
          {"geoms", geoms(scene)},
          {"meshes", meshes(scene)},
          {"sites", sites(scene)}};
}

}  // namespace baton
