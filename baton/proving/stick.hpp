/// A random stick: what a hand, a child or a broken device may do. A function of its seed, the same on every computer.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "baton/input/device.hpp"
#include "baton/proving/dice.hpp"

namespace baton {

class Stick : public Device {
 public:
  /// What goes on at the stick for some time.
  enum class Style {
    calm,       ///< one clear wish, held for seconds
    full,       ///< axes at their stops, alone or together
    any,        ///< six axes at random
    hectic,     ///< a new command every few ticks
    reversal,   ///< back and forth, all the way
    modes,      ///< another guided part at every tick
    pinned,     ///< the stick does not move for minutes
    throttles,  ///< both levers up and down
    broken,     ///< not a number, denormal, infinite, out of range
    centred,    ///< let go
    recall,     ///< back along what was done, home, or stop, whatever the stick does meanwhile
  };
  static constexpr std::array<std::string_view, 11> kNames{
      "calm", "full", "any", "hectic", "reversal", "modes", "pinned", "throttles", "broken", "centred", "recall"};

  /// @param period of a tick [s]
  Stick(std::uint64_t seed, double period);

  /// The command of the next tick. Unless pinned, the stick is let go of for moments at random, as if the device were
  /// lost. Up to the current stretch it has been deflected for at least 75 % of the time.
  [[nodiscard]] Command next();

  /// As `next`; call it once a tick.
  [[nodiscard]] Command read(double /*t*/) override { return next(); }
  [[nodiscard]] DeviceStatus status() const override;

  /// Of the last command.
  [[nodiscard]] Style style() const { return style_; }

  /// Whether a command asks for something that can be seen: an axis or the guided foot's lever beyond 1/20.
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
  int stretch_ = 0;     ///< ticks that the style goes on
  int hold_ = 0;        ///< ticks until the next command
  int until_away_ = 0;  ///< ticks until the device is lost, or let go of, for a moment
  int away_ = 0;        ///< ticks until it is back
  int pace_ = 1;        ///< ticks from one reversal to the next
  bool first_ = true;
  Command command_;
  long ticks_ = 0;
  long deflected_ = 0;
};

/// The commands of a stick in the ticks 0 … `ticks` − 1 of a run as a script (docs/input.md) that gives the very same
/// commands, and at the end lets go.
[[nodiscard]] std::string stick_script(Device& stick, double period, long ticks);

}  // namespace baton
