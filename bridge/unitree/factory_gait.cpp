#include "bridge/unitree/factory_gait.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace baton::unitree {
namespace {

/// The gait's name in an answer; none: it is no proper answer.
std::optional<std::string> name_in(const std::string& data) {
  const nlohmann::json json = nlohmann::json::parse(data, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  const auto name = json.find("name");
  if (name == json.end() || !name->is_string()) return std::nullopt;
  return name->get<std::string>();
}

}  // namespace

std::optional<FactoryGait::Request> FactoryGait::next(double t) {
  if (waiting_ && t >= due_) in_vain("does not answer", t);
  if (state_ != State::asking || waiting_ || t < due_) return std::nullopt;
  waiting_ = true;
  due_ = t + parameters_.answering;
  return Request{id_++, api_};
}

void FactoryGait::answer(std::int64_t id, int code, const std::string& data, double t) {
  if (state_ != State::asking || !waiting_ || id != id_ - 1) return;
  if (code != 0) return in_vain(fmt::format("answers with the error {}", code), t);
  if (api_ == Api::release_mode) {
    waiting_ = false;
    in_vain_ = 0;
    ++releases_;
    api_ = Api::check_mode;
    due_ = t + parameters_.releasing;
    return;
  }
  const std::optional<std::string> name = name_in(data);
  if (!name) return in_vain("answers with something else than a mode", t);
  waiting_ = false;
  in_vain_ = 0;
  due_ = t;
  if (name->empty()) {
    state_ = State::released;
    return;
  }
  name_ = *name;
  if (releases_ >= parameters_.releases) {
    state_ = State::failed;
    why_ = fmt::format("the factory gait '{}' is still active after it was told {} times to end", name_, releases_);
    return;
  }
  api_ = Api::release_mode;
}

void FactoryGait::in_vain(const std::string& why, double t) {
  waiting_ = false;
  due_ = std::max(due_, t);  // an error that comes at once is not asked for again before its time
  if (++in_vain_ < parameters_.questions) return;
  state_ = State::failed;
  why_ = fmt::format("the motion switcher {}, so whether the factory gait is active is not known", why);
}

}  // namespace baton::unitree
