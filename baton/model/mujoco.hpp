/// MuJoCo with owners for what it allocates, and its errors as exceptions.
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

/// Makes MuJoCo's fatal errors throw std::runtime_error instead of ending the process, and its warnings go to
/// `mujoco_warnings()` instead of a log file. Called by everything below; harmless to call again.
void install_mujoco_handlers();

/// MuJoCo's parser and compiler are not made for several threads: whoever works on a spec holds this. Everything below
/// does, and may be called by who holds it.
[[nodiscard]] std::unique_lock<std::recursive_mutex> lock_compiler();

/// Number of warnings that MuJoCo has given on this thread since the start (a warning ends a run as a failure).
[[nodiscard]] int mujoco_warnings();

/// Reads an MJCF or URDF file.
/// @throws InputError missing, or not a model; the message is the parser's
[[nodiscard]] SpecPtr parse_model(const std::filesystem::path& file);

/// @throws InputError the model does not compile; `what` names it in the message
[[nodiscard]] ModelPtr compile_model(mjSpec& spec, const std::string& what);

/// Reads MJCF text; `what` names it in messages.
/// @throws InputError it is not a model
[[nodiscard]] SpecPtr parse_text(const std::string& mjcf, const std::string& what);

/// A model as MJCF text. It must have been compiled since it was last changed.
/// @throws InputError it has no text
[[nodiscard]] std::string text_of(const mjSpec& spec, const std::string& what);

/// Compiles MJCF text.
/// @throws InputError as above
[[nodiscard]] ModelPtr compile_text(const std::string& mjcf, const std::string& what);

/// Id of a named element, of type mjOBJ_*.
/// @throws InputError no such element; the message names `owner`, the kind and the name
[[nodiscard]] int find_id(const mjModel& model, mjtObj type, const std::string& name, const std::string& owner);

/// Name of an element, "" if it has none.
[[nodiscard]] std::string name_of(const mjModel& model, mjtObj type, int id);

}  // namespace baton
