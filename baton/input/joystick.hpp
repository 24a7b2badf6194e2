/// Joysticks and pads through SDL2, with hot-plugging and arming.
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

/// Uses the first device that SDL finds usable: an AV8R (by USB id, or any stick with its layout) or a pad with an SDL
/// game-controller mapping. It is kept until unplugged; then the next one is taken. Commands count once every control,
/// triggers included, has been at rest; a lever counts once it has been pulled back. Until then the command is neutral,
/// for the part guided last.
///
/// Needs no display and no thread. `read` must be called from one thread.
class Joystick : public Device {
 public:
  struct Parameters {
    Av8rMapping av8r{};
    PadMapping pad{};
    bool dead_man = true;  ///< a pad needs its left shoulder button held
    /// A deflected device without any change for longer than this counts as lost [s]. Some links die silently, but a
    /// stick held at its stop is just as silent, so the default is no limit.
    double max_age = std::numeric_limits<double>::infinity();
  };

  /// @throws InputError `max_age` is not positive, or `lever_forward` is not ±1
  /// @throws std::runtime_error SDL's joystick subsystem fails to start
  explicit Joystick(const Parameters& parameters);
  Joystick() : Joystick(Parameters{}) {}
  ~Joystick() override;
  Joystick(const Joystick&) = delete;
  Joystick& operator=(const Joystick&) = delete;

  [[nodiscard]] Command read(double t) override;
  [[nodiscard]] DeviceStatus status() const override;

  /// Time from the device's last change to the last `read` [s]; infinite without a device.
  [[nodiscard]] double age() const;

 private:
  struct Handle;
  using Controls = std::variant<std::monostate, Av8rState, PadState>;

  void find();
  [[nodiscard]] Controls controls() const;
  /// Command of these controls, ignoring the dead-man button; updates the chosen part.
  [[nodiscard]] Command command_of(const Controls& controls);
  [[nodiscard]] bool dead_man_released() const;

  Parameters parameters_;
  std::unique_ptr<Handle> handle_;     ///< null without a device
  std::vector<std::int32_t> refused_;  ///< SDL instance ids of unusable devices
  std::string refused_name_;           ///< name of one that is plugged in
  Arming arming_;
  Controls controls_;         ///< newest
  double now_ = 0.0;          ///< time of the last `read` [s]
  double changed_ = 0.0;      ///< time of the controls' last change [s]
  BySide<bool> lever_known_;  ///< this AV8R lever has been pulled back once
  Side side_ = Side::left;    ///< last chosen on an AV8R
  Part guide_ = Part::trunk;  ///< last guided
};

}  // namespace baton
