/// Joysticks and pads by SDL2: plugged in and out at any time, neutral before armed.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "baton/input/arming.hpp"
#include "baton/input/av8r.hpp"
#include "baton/input/device.hpp"
#include "baton/input/pad.hpp"

namespace baton {

/// The first usable device that SDL sees: an AV8R (by its USB id, or any stick with its layout) or a pad that
/// SDL has a game-controller mapping for. It is kept until it goes; then the next one is taken. Its commands
/// count once every control was at rest, triggers too; a lever counts once it was pulled back. While none counts, the
/// command is neutral for the part guided last.
///
/// Needs no display and no thread of its own. One thread calls `read`.
class Joystick : public Device {
 public:
  struct Parameters {
    Av8rMapping av8r{};
    PadMapping pad{};
    bool dead_man = true;  ///< a pad moves the robot only while its left shoulder button is held
    /// A deflected device that reports no change for longer counts as lost [s]. Some links die silently, but
    /// a stick held at its stop is just as silent: so there is no limit unless one is asked for.
    double max_age = std::numeric_limits<double>::infinity();
  };

  /// @throws InputError `max_age` is not positive, or `lever_forward` neither −1 nor +1
  /// @throws std::runtime_error SDL cannot start its joystick subsystem
  explicit Joystick(const Parameters& parameters);
  Joystick() : Joystick(Parameters{}) {}
  ~Joystick() override;
  Joystick(const Joystick&) = delete;
  Joystick& operator=(const Joystick&) = delete;

  [[nodiscard]] Command read(double t) override;
  [[nodiscard]] DeviceStatus status() const override;

  /// Since the device last reported a change, at the time of the last `read` [s]; infinite while there is
  /// none.
  [[nodiscard]] double age() const;

 private:
  struct Handle;
  using Controls = std::variant<std::monostate, Av8rState, PadState>;

  void find();
  [[nodiscard]] Controls controls() const;
  /// The command of the controls as they are, dead-man button aside; follows the choice of part.
  [[nodiscard]] Command command_of(const Controls& controls);
  [[nodiscard]] bool dead_man_released() const;

  Parameters parameters_;
  std::unique_ptr<Handle> handle_;     ///< empty while there is no device
  std::vector<std::int32_t> refused_;  ///< SDL's instance ids of devices that cannot be used
  std::string refused_name_;           ///< one of those that is there now
  Arming arming_;
  Controls controls_;         ///< newest
  double now_ = 0.0;          ///< time of the last read [s]
  double changed_ = 0.0;      ///< time at which the controls last changed [s]
  BySide<bool> lever_known_;  ///< an AV8R's lever was seen pulled back
  Side side_ = Side::left;    ///< chosen last on an AV8R
  Part guide_ = Part::trunk;  ///< guided last
};

}  // namespace baton
