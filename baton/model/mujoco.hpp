/// MuJoCo with smart pointers, and its errors as exceptions.
#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

namespace baton {

struct MujocoDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using ModelPtr = std::unique_ptr<mjModel, MujocoDeleter>;
using DataPtr = std::unique_ptr<mjData, MujocoDeleter>;
using SpecPtr = std::unique_ptr<mjSpec, MujocoDeleter>;

/// Makes MuJoCo's fatal errors throw std::runtime_error instead of ending the process, and counts its warnings in
/// `mujoco_warnings()` instead of logging them. All functions below call it; calling it again does nothing.
void install_mujoco_handlers();
/// For a process in which others use MuJoCo as well: from now on, warnings outside of `OwnMujoco` go where they went.
void share_mujoco();

/// While it lives, MuJoCo is called by us on this thread; or, with `own` false, by others.
class OwnMujoco {
 public:
  explicit OwnMujoco(bool own = true);
  OwnMujoco(const OwnMujoco&) = delete;
  OwnMujoco& operator=(const OwnMujoco&) = delete;
  ~OwnMujoco();

 private:
  int before_;
};

/// Lock to hold while working on a spec: MuJoCo's parser and compiler are not thread-safe. The functions below take it
/// themselves; it is recursive.
[[nodiscard]] std::unique_lock<std::recursive_mutex> lock_compiler();

/// Number of MuJoCo warnings on this thread so far.
[[nodiscard]] int mujoco_warnings();

/// Reads an MJCF or URDF file.
/// @throws InputError no such file, or not a model; the message is the parser's
[[nodiscard]] SpecPtr parse_model(const std::filesystem::path& file);

/// @param what name of the model in messages
/// @throws InputError the model does not compile
[[nodiscard]] ModelPtr compile_model(mjSpec& spec, const std::string& what);

/// Parses MJCF text.
/// @param what its name in messages
/// @throws InputError not a model
[[nodiscard]] SpecPtr parse_text(const std::string& mjcf, const std::string& what);

/// A model as MJCF text. It must have been compiled since its last change.
/// @throws InputError MuJoCo cannot write it
[[nodiscard]] std::string text_of(const mjSpec& spec, const std::string& what);

/// Compiles MJCF text.
/// @throws InputError as above
[[nodiscard]] ModelPtr compile_text(const std::string& mjcf, const std::string& what);

/// Id of a named element of type mjOBJ_*.
/// @throws InputError no such element; the message has `owner`, type and name
[[nodiscard]] int find_id(const mjModel& model, mjtObj type, const std::string& name, const std::string& owner);

/// Name of an element, "" if it has none.
[[nodiscard]] std::string name_of(const mjModel& model, mjtObj type, int id);

}  // namespace baton
