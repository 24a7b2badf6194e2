/// What is read: the devices that may drive, and which of them counts at the moment; what files name.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baton/input/device.hpp"
#include "baton/model/error.hpp"

namespace baton::app {

/// What `load` returns.
/// @param place file, and line, that names what is loaded: messages begin with it
template <typename Load>
auto named_in(const std::string& place, const Load& load) {
  try {
    return load();
  } catch (const InputError& error) {
    throw InputError(place + ": " + error.what());
  }
}

class Inputs : public Device {
 public:
  /// @param choice auto, joystick, page or script:FILE
  /// @param fast the run does not wait for the clock, and so not for a joystick to be plugged in
  /// @throws InputError any other choice, a script that is not one, or a joystick that is not there with `fast`
  Inputs(const std::string& choice, bool fast);

  /// The page, if there is one, as a device; unused where the choice is a joystick or a script.
  void add_page(Device& page);

  /// The script, if it is one.
  [[nodiscard]] std::optional<std::filesystem::path> script() const;

  /// The newest command of the device that counts: the armed one that is in use, until it rests and another is not.
  /// After a stop, what a live device still holds moves nothing until it has been let go of once.
  [[nodiscard]] Command read(double t) override;

  [[nodiscard]] DeviceStatus status() const override;

 private:
  std::string choice_;
  std::vector<std::unique_ptr<Device>> owned_;
  std::vector<Device*> devices_;
  const Device* active_ = nullptr;
  std::vector<const Device*> held_;  ///< since a stop, not let go of yet
};

}  // namespace baton::app
