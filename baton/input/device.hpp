/// Port for everything that an operator holds: joystick, pad, keys in the page, script. Of the run it knows only the
/// time.
#pragma once

#include <string>

#include "baton/run/operator.hpp"

namespace baton {

/// A device as its operator should see it.
struct DeviceStatus {
  std::string name;        ///< of the device, for people; empty while there is none
  bool connected = false;  ///< something is there that could give commands
  bool armed = false;      ///< its commands count: it was neutral once since it appeared
  std::string hint;        ///< what the operator has to do for that, one short sentence; empty if nothing
};

class Device : public Operator {
 public:
  /// The newest command at time `t` [s, of the run]. Neutral while the device is absent, silent, or not
  /// armed. Never throws and never blocks.
  [[nodiscard]] virtual Command read(double t) = 0;

  [[nodiscard]] virtual DeviceStatus status() const = 0;

  [[nodiscard]] Command decide(const View& view) final { return read(view.t); }
};

}  // namespace baton
