/// A random stick: what a hand, a child or a broken device might do. A function of its seed, identical on every
/// platform.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "baton/input/device.hpp"
#include "baton/proving/dice.hpp"

namespace baton {

class Stick : public Device {
 public:
  /// How the stick behaves for some time.
  enum class Style {
    calm,       ///< one clear command, held for seconds
    full,       ///< axes at their stops, one or several
    any,        ///< six axes at random
    hectic,     ///< a new command every few ticks
    reversal,   ///< full reversals
    modes,      ///< another guided part at every tick
    pinned,     ///< the stick does not move for minutes
    throttles,  ///< both levers up and down
    broken,     ///< NaN, denormal, infinite, out of range
    centred,    ///< released
    recall,     ///< retrace, home or stop, whatever the axes do
  };
  static constexpr std::array<std::string_view, 11> kNames{
      "calm", "full", "any", "hectic", "reversal", "modes", "pinned", "throttles", "broken", "centred", "recall"};

  /// @param period tick period [s]
  Stick(std::uint64_t seed, double period);

  /// The command of the next tick. Unless pinned, the stick is released briefly at random, as if the device were lost.
  /// Until the current stretch it has been deflected at least 75 % of the time.
  [[nodiscard]] Command next();

  /// Same as `next`; call once per tick.
  [[nodiscard]] Command read(double /*t*/) override { return next(); }
  [[nodiscard]] DeviceStatus status() const override;

  /// Of the last command.
  [[nodiscard]] Style style() const { return style_; }

  /// Whether a command asks for something visible: an axis or the guided foot's lever beyond 1/20.
  [[nodiscard]] static bool deflected(const Command& command);

 private:
  [[nodiscard]] int ticks(int milliseconds_lo, int milliseconds_hi);
  void begin_stretch();
  void draw();
  void wish();
  [[nodiscard]] Vec6 axes();
  [[nodiscard]] double lever();
  [[nodiscard]] double strange();

  Dice dice_;
  double period_;
  Style style_ = Style::centred;
  int stretch_ = 0;     ///< remaining ticks of the style
  int hold_ = 0;        ///< ticks until the next command
  int until_away_ = 0;  ///< ticks until the next brief release or loss
  int away_ = 0;        ///< ticks until it is back
  int pace_ = 1;        ///< ticks between reversals
  bool first_ = true;
  Command command_;
  long ticks_ = 0;
  long deflected_ = 0;
};

/// The stick's commands of ticks 0 … `ticks` − 1 as a script (docs/input.md) that reproduces them exactly, then
/// releases.
[[nodiscard]] std::string stick_script(Device& stick, double period, long ticks);

}  // namespace baton
