/// The devices that may drive: which of them counts at the moment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "baton/input/device.hpp"

namespace baton::app {

class Inputs {
 public:
  /// @param choice auto, joystick, page or script:FILE
  /// @throws InputError any other choice, or a script that is not one
  explicit Inputs(const std::string& choice);

  /// The page, if there is one, as a device; unused where the choice is a joystick or a script.
  void add_page(Device& page);

  /// The newest command of the device that counts: the armed one that is in use, until it rests and another is not.
  [[nodiscard]] Command read(double t);

  [[nodiscard]] DeviceStatus status() const;

 private:
  std::string choice_;
  std::vector<std::unique_ptr<Device>> owned_;
  std::vector<Device*> devices_;
  const Device* active_ = nullptr;
};

}  // namespace baton::app
