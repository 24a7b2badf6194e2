/// Inputs of the program: the input devices, and which of them is in command.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baton/input/device.hpp"
#include "baton/model/error.hpp"

namespace baton::app {

/// Returns `load()`; prefixes its errors with `place`.
/// @param place file, and line, that refers to what is loaded
template <typename Load>
auto named_in(const std::string& place, const Load& load) {
  try {
    return load();
  } catch (const InputError& error) {
    throw InputError(place + ": " + error.what());
  }
}

/// FILE of "script:FILE"; none: it is something else.
[[nodiscard]] std::optional<std::filesystem::path> script_in(const std::string& choice);

class Inputs : public Device {
 public:
  /// @param choice auto, joystick, page or script:FILE
  /// @param fast the run is not in real time, so it cannot wait for a joystick
  /// @throws InputError unknown choice, invalid script, or with `fast` no joystick
  Inputs(const std::string& choice, bool fast);

  /// Adds the page as a device; ignored if the choice is a joystick or a script.
  void add_page(Device& page);

  /// The script's file, if the choice is a script.
  [[nodiscard]] std::optional<std::filesystem::path> script() const { return script_in(choice_); }

  /// The newest command of the active device: an armed one stays active until it is at rest and another one is not.
  /// After a stop, a live device that is still deflected counts again only once it has been released.
  [[nodiscard]] Command read(double t) override;

  [[nodiscard]] DeviceStatus status() const override;

 private:
  std::string choice_;
  std::vector<std::unique_ptr<Device>> owned_;
  std::vector<Device*> devices_;
  const Device* active_ = nullptr;
  std::vector<const Device*> held_;  ///< still deflected since a stop
};

}  // namespace baton::app
