/// What the operator asks for: the newest position of the stick.
#pragma once

#include <cstdint>

#include "baton/motion/posture.hpp"

namespace baton {

/// What a button asks for in place of the stick.
enum class Recall : std::uint8_t {
  none,
  retrace,  ///< what was done last, backwards
  home,     ///< steps to the stance that the robot began in
  stop,     ///< to rest, as quickly as that can be verified
};

/// Of several buttons held, stop wins, then retrace.
[[nodiscard]] constexpr Recall recall_of(bool stop, bool retrace, bool home) {
  return stop ? Recall::stop : retrace ? Recall::retrace : home ? Recall::home : Recall::none;
}

/// Axes are in −1…1, positive by the right hand in the heading frame: x forward, y left, z up, roll, pitch, yaw;
/// `lift` is in 0…1, for each foot. Dead zone and curve are behind us: devices apply them.
struct Command {
  Part guide = Part::trunk;
  Vec6 axes = Vec6::Zero();
  BySide<double> lift{0.0, 0.0};
  Recall recall = Recall::none;

  /// No recall, all axes centred and the lift of the guided foot, if a foot is guided, zero.
  [[nodiscard]] bool neutral() const {
    return recall == Recall::none && axes.isZero(0.0) && (!is_foot(guide) || lift[side_of(guide)] == 0.0);
  }
  [[nodiscard]] bool operator==(const Command& other) const {
    return guide == other.guide && axes == other.axes && lift.left == other.lift.left &&
           lift.right == other.lift.right && recall == other.recall;
  }
};

/// Whether the lever of the foot that `a` guides is elsewhere than in `b`, beyond the jitter of a device.
[[nodiscard]] bool lever_moved(const Command& a, const Command& b);

/// Whether a command asks for something else than another, beyond the jitter of a device; recalls aside.
[[nodiscard]] bool differs(const Command& a, const Command& b);

/// The command as it may be acted on: axes clamped to −1…1 and lifts to 0…1; what is not a number stands for a
/// broken device and counts as centred.
[[nodiscard]] Command sanitised(const Command& command);

}  // namespace baton
