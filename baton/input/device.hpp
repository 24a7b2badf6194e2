/// Interface to input devices: joystick, pad, keys on the page, script. A device knows only the time of the run.
#pragma once

#include <string>

#include "baton/run/operator.hpp"

namespace baton {

/// Device state as shown to the operator.
struct DeviceStatus {
  std::string name;        ///< display name; empty without a device
  bool connected = false;  ///< present and able to give commands
  bool armed = false;      ///< its commands count: its controls were released since it was connected
  std::string hint;        ///< one short sentence: what the operator must do to arm it; may be empty
};

class Device : public Operator {
 public:
  /// Newest command at run time `t` [s]; neutral while the device is absent, silent or not armed. Never throws or
  /// blocks.
  [[nodiscard]] virtual Command read(double t) = 0;

  [[nodiscard]] virtual DeviceStatus status() const = 0;

  [[nodiscard]] Command decide(const View& view) final { return read(view.t); }
};

}  // namespace baton
