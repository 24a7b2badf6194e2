#include "app/inputs.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "app/commands.hpp"
#include "baton/input/joystick.hpp"
#include "baton/input/script.hpp"
#include "baton/model/error.hpp"

namespace baton::app {

Inputs::Inputs(const std::string& choice, bool fast) : choice_(choice) {
  if (const auto file = script()) {
    owned_.push_back(std::make_unique<Script>(Script::load(*file, interrupted)));
  } else if (choice == "joystick") {
    auto joystick = std::make_unique<Joystick>();
    static_cast<void>(joystick->read(0.0));  // searches for a joystick
    if (const DeviceStatus status = joystick->status(); !status.connected) {
      if (fast) throw InputError(fmt::format("--input joystick with --fast: no joystick found: {}", status.hint));
      spdlog::warn("--input joystick: none found yet: {}", status.hint);
    }
    owned_.push_back(std::move(joystick));
  } else if (choice == "auto") {
    try {
      owned_.push_back(std::make_unique<Joystick>());
    } catch (const std::exception& error) {
      spdlog::warn("continuing without a joystick: {}", error.what());
    }
  } else if (choice != "page") {
    throw InputError(fmt::format("--input {}: must be auto, joystick, page or script:FILE", choice));
  }
  for (const auto& device : owned_)
    devices_.push_back(device.get());
}

std::optional<std::filesystem::path> script_in(const std::string& choice) {
  const std::string script = "script:";
  if (!choice.starts_with(script)) return std::nullopt;
  return choice.substr(script.size());
}

void Inputs::add_page(Device& page) {
  if (choice_ == "auto" || choice_ == "page") devices_.push_back(&page);
}

Command Inputs::read(double t) {
  struct Reading {
    const Device* device;
    Command command;
    bool armed;
  };
  std::vector<Reading> readings;
  for (Device* device : devices_) {
    Command command = device->read(t);
    if (command.neutral()) std::erase(held_, device);
    const bool held = std::find(held_.begin(), held_.end(), device) != held_.end();
    if (held && command.recall != Recall::stop) command = {.guide = command.guide};
    readings.push_back({device, command, device->status().armed});
  }
  const auto find = [&](const auto& fits) {
    const auto it = std::find_if(readings.begin(), readings.end(), fits);
    return it == readings.end() ? nullptr : &*it;
  };
  // Any device may stop. Otherwise the active device stays active until it is at rest and another one is not.
  const Reading* chosen = find([](const Reading& r) { return r.armed && r.command.recall == Recall::stop; });
  if (chosen == nullptr)
    chosen = find([&](const Reading& r) { return r.armed && r.device == active_ && !r.command.neutral(); });
  if (chosen == nullptr) chosen = find([](const Reading& r) { return r.armed && !r.command.neutral(); });
  if (chosen == nullptr) chosen = find([&](const Reading& r) { return r.armed && r.device == active_; });
  if (chosen == nullptr) chosen = find([](const Reading& r) { return r.armed; });
  active_ = chosen == nullptr ? nullptr : chosen->device;
  if (chosen != nullptr && chosen->command.recall == Recall::stop && !script())
    held_.assign(devices_.begin(), devices_.end());
  if (chosen != nullptr) return chosen->command;
  return readings.empty() ? Command{} : readings.back().command;
}

DeviceStatus Inputs::status() const {
  if (active_ != nullptr) return active_->status();
  DeviceStatus newest;
  for (const Device* device : devices_) {
    const DeviceStatus status = device->status();
    if (newest.name.empty() || status.connected) newest = status;
  }
  return newest;
}

}  // namespace baton::app
