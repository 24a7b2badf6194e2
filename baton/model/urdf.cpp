#include "baton/model/urdf.hpp"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <cstdlib>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <string_view>
#include <vector>

#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"

namespace baton {
namespace {

namespace fs = std::filesystem;

pugi::xml_document parsed(const fs::path& file) {
  const std::string text = read_input(file, "model");
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result) throw InputError(fmt::format("model {}: {}", file.string(), result.description()));
  if (!document.child("robot")) {
    throw InputError(fmt::format("model {}: a URDF needs the element <robot>", file.string()));
  }
  return document;
}

/// The folders that may hold a package of a URDF.
std::vector<fs::path> package_folders(const fs::path& file) {
  std::vector<fs::path> folders;
  for (fs::path folder = fs::absolute(file).parent_path(); folder.has_relative_path(); folder = folder.parent_path()) {
    folders.push_back(folder);
    folders.push_back(folder / "share");
  }
  if (const char* given = std::getenv("ROS_PACKAGE_PATH")) {
    std::istringstream list(given);
    for (std::string folder; std::getline(list, folder, ':');)
      folders.emplace_back(folder);
  }
  return folders;
}

/// Absolute path of a mesh.
fs::path resolved(const std::string& name, const fs::path& file) {
  constexpr std::string_view package = "package://";
  constexpr std::string_view plain = "file://";
  std::error_code ignored;
  if (name.starts_with(package)) {
    const fs::path inside = name.substr(package.size());
    for (const fs::path& folder : package_folders(file)) {
      if (fs::exists(folder / inside, ignored)) return folder / inside;
      // The folder of the package itself may have another name.
      const fs::path rest = inside.lexically_relative(*inside.begin());
      if (fs::exists(folder / rest, ignored)) return folder / rest;
    }
  } else {
    const fs::path path = name.starts_with(plain) ? name.substr(plain.size()) : name;
    const fs::path absolute = path.is_absolute() ? path : fs::absolute(file).parent_path() / path;
    if (fs::exists(absolute, ignored)) return absolute;
  }
  throw InputError(
      fmt::format("model {}: mesh '{}' is nowhere: put its package beside the file, or its folder into "
                  "ROS_PACKAGE_PATH",
                  file.string(), name));
}

/// Adds the meshes below a node of a Collada scene, in the frame of its root.
void collect(const aiScene& scene, const aiNode& node, const aiMatrix4x4& above, std::vector<float>& vertices,
             std::vector<int>& faces) {
  const aiMatrix4x4 at = above * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    const int first = static_cast<int>(vertices.size() / 3);
    for (unsigned k = 0; k < mesh.mNumVertices; ++k) {
      const aiVector3D v = at * mesh.mVertices[k];
      vertices.insert(vertices.end(), {v.x, v.y, v.z});
    }
    for (unsigned k = 0; k < mesh.mNumFaces; ++k) {
      if (mesh.mFaces[k].mNumIndices != 3) continue;
      for (unsigned n = 0; n < 3; ++n)
        faces.push_back(first + static_cast<int>(mesh.mFaces[k].mIndices[n]));
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    collect(scene, *node.mChildren[i], at, vertices, faces);
}

/// MuJoCo reads no Collada: hands the vertices over.
void read_collada(mjsMesh& mesh, const fs::path& file) {
  Assimp::Importer importer;
  importer.SetPropertyBool("IMPORT_COLLADA_IGNORE_UP_DIRECTION", true);  // ROS takes the coordinates as they are
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw InputError(fmt::format("mesh {}: {}", file.string(), importer.GetErrorString()));
  }
  std::vector<float> vertices;
  std::vector<int> faces;
  collect(*scene, *scene->mRootNode, aiMatrix4x4(), vertices, faces);
  if (faces.empty()) throw InputError(fmt::format("mesh {}: it has no faces", file.string()));
  mjs_setFloat(mesh.uservert, vertices.data(), static_cast<int>(vertices.size()));
  mjs_setInt(mesh.userface, faces.data(), static_cast<int>(faces.size()));
  mjs_setString(mesh.file, "");
}

}  // namespace

bool is_urdf(const fs::path& file) {
  return file.extension() == ".urdf";
}

SpecPtr parse_urdf(const fs::path& file) {
  pugi::xml_document document = parsed(file);
  pugi::xml_node robot = document.child("robot");
  for (const pugi::xpath_node& found : document.select_nodes("//mesh[@filename]")) {
    pugi::xml_attribute name = found.node().attribute("filename");
    name.set_value(resolved(name.value(), file).c_str());
  }
  // Of the joints that one motor drives together, the others move by a fixed law; hands are driven as a whole.
  for (const pugi::xpath_node& found : document.select_nodes("/robot/joint[mimic]"))
    found.node().attribute("type").set_value("fixed");
  pugi::xml_node compiler = robot.child("mujoco") ? robot.child("mujoco") : robot.append_child("mujoco");
  compiler = compiler.child("compiler") ? compiler.child("compiler") : compiler.append_child("compiler");
  for (const auto& [name, value] : {std::pair("strippath", "false"), std::pair("discardvisual", "false")}) {
    compiler.remove_attribute(name);
    compiler.append_attribute(name).set_value(value);
  }
  std::ostringstream text;
  document.save(text);
  SpecPtr spec = parse_text(text.str(), fmt::format("model {}", file.string()));
  const auto lock = lock_compiler();
  for (mjsElement* e = mjs_firstElement(spec.get(), mjOBJ_MESH); e != nullptr; e = mjs_nextElement(spec.get(), e)) {
    mjsMesh& mesh = *mjs_asMesh(e);
    const fs::path from = mjs_getString(mesh.file);
    if (from.extension() == ".dae" || from.extension() == ".DAE") read_collada(mesh, from);
  }
  return spec;
}

std::map<std::string, double> urdf_speed_limits(const fs::path& file) {
  std::map<std::string, double> limits;
  const pugi::xml_document document = parsed(file);
  for (const pugi::xml_node& joint : document.child("robot").children("joint")) {
    const double speed = joint.child("limit").attribute("velocity").as_double();
    if (speed > 0.0) limits[joint.attribute("name").value()] = speed;
  }
  return limits;
}

}  // namespace baton
