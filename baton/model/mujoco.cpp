#include "baton/model/mujoco.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"

namespace baton {
namespace {

thread_local int warnings = 0;
thread_local int own_calls = 0;
std::atomic<bool> shared = false;
void (*others)(const char*) = nullptr;  ///< the handler that was there before

void on_error(const char* message) {
  throw std::runtime_error(fmt::format("MuJoCo: {}", message));
}
void on_warning(const char* message) {
  ++warnings;
  if (!shared || own_calls > 0) return;
  if (others != nullptr) {
    others(message);
  } else {
    fmt::print(stderr, "WARNING: {}\n", message);
  }
}

/// The parser's message, which may have several lines, on one.
std::string one_line(std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  return message;
}

}  // namespace

void install_mujoco_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = on_error;
    others = mju_user_warning;
    mju_user_warning = on_warning;
  });
}

void share_mujoco() {
  shared = true;
}

OwnMujoco::OwnMujoco(bool own) : before_(std::exchange(own_calls, own ? own_calls + 1 : 0)) {}
OwnMujoco::~OwnMujoco() {
  own_calls = before_;
}

std::unique_lock<std::recursive_mutex> lock_compiler() {
  static std::recursive_mutex compiler;
  return std::unique_lock(compiler);
}

int mujoco_warnings() {
  return warnings;
}

SpecPtr parse_model(const std::filesystem::path& file) {
  install_mujoco_handlers();
  check_input(file, "model");
  const auto lock = lock_compiler();
  std::array<char, 1000> message{};
  SpecPtr spec(mj_parseXML(file.c_str(), nullptr, message.data(), message.size()));
  if (!spec) throw InputError(fmt::format("model {}: {}", file.string(), one_line(message.data())));
  return spec;
}

ModelPtr compile_model(mjSpec& spec, const std::string& what) {
  const auto lock = lock_compiler();
  ModelPtr model(mj_compile(&spec, nullptr));
  if (!model) throw InputError(fmt::format("{}: {}", what, one_line(mjs_getError(&spec))));
  return model;
}

SpecPtr parse_text(const std::string& mjcf, const std::string& what) {
  install_mujoco_handlers();
  const auto lock = lock_compiler();
  std::array<char, 1000> message{};
  SpecPtr spec(mj_parseXMLString(mjcf.c_str(), nullptr, message.data(), message.size()));
  if (!spec) throw InputError(fmt::format("{}: {}", what, one_line(message.data())));
  return spec;
}

std::string text_of(const mjSpec& spec, const std::string& what) {
  constexpr std::size_t kLongest = 1 << 22;
  std::array<char, 1000> message{};
  std::vector<char> text(kLongest);
  if (mj_saveXMLString(&spec, text.data(), static_cast<int>(text.size()), message.data(), message.size()) != 0) {
    throw InputError(fmt::format("{}: {}", what, one_line(message.data())));
  }
  return text.data();
}

ModelPtr compile_text(const std::string& mjcf, const std::string& what) {
  const auto lock = lock_compiler();
  return compile_model(*parse_text(mjcf, what), what);
}

int find_id(const mjModel& model, mjtObj type, const std::string& name, const std::string& owner) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) throw InputError(fmt::format("{}: no {} named '{}'", owner, mju_type2Str(type), name));
  return id;
}

std::string name_of(const mjModel& model, mjtObj type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name == nullptr ? "" : name;
}

}  // namespace baton
