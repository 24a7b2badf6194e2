/// Xbox-like pads: controls in SDL's game-controller naming → command (docs/input.md).
#pragma once

#include "baton/guide/command.hpp"
#include "baton/input/response.hpp"

namespace baton {

struct PadState {
  double left_right = 0.0;  ///< left stick, −1…1, right positive
  double left_down = 0.0;   ///< left stick, down positive
  double right_right = 0.0;
  double right_down = 0.0;
  double left_trigger = 0.0;  ///< 0…1
  double right_trigger = 0.0;
  bool left_shoulder = false;  ///< the dead-man button
  bool right_shoulder = false;
  bool a = false, b = false, x = false, y = false;
  bool back = false, start = false;
  bool stick = false;                                          ///< left or right stick pressed in
  bool up = false, down = false, left = false, right = false;  ///< d-pad

  [[nodiscard]] bool operator==(const PadState&) const = default;
};

struct PadMapping {
  Response stick{};
  Response trigger{{.curve = 0.0}};
};

/// The guided part: A trunk, X left foot, B right foot, Y left hand, right shoulder right hand; none or several pressed
/// keep `previous`.
[[nodiscard]] Part pad_guide(const PadState& state, Part previous);

/// Maps any state to a command: axes in −1…1, lifts in 0…1. A stick pressed in stops, back retraces, start goes home.
/// Ignores the dead-man button.
[[nodiscard]] Command pad_command(const PadState& state, Part guide, const PadMapping& mapping = {});

}  // namespace baton
