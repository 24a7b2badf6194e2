/// Saitek Aviator AV8R, the paper's joystick: controls → command (table in docs/input.md).
#pragma once

#include <array>

#include "baton/guide/command.hpp"
#include "baton/input/response.hpp"

namespace baton {

/// Controls in SDL's numbering.
struct Av8rState {
  static constexpr int kAxes = 5;
  static constexpr int kButtons = 14;

  std::array<double, kAxes> axes{};      ///< −1…1: stick right, stick aft, lever 1, twist right, lever 2
  std::array<bool, kButtons> buttons{};  ///< trigger, launcher, main, sub, T1…T8, mode A, mode B
  int hat_right = 0;                     ///< mini stick: −1, 0 or 1
  int hat_up = 0;                        ///< mini stick: −1, 0 or 1

  [[nodiscard]] bool operator==(const Av8rState&) const = default;
};

struct Av8rMapping {
  Response stick{};                ///< main stick and twist
  Response lever{{.curve = 0.0}};  ///< levers; dead zone at the pulled end
  double lever_forward = -1.0;     ///< reading of a lever pushed fully forward, −1 or +1
};

/// Side of the guided foot or hand: launcher selects left, main right; neither or both keeps `previous`.
[[nodiscard]] Side av8r_side(const Av8rState& state, Side previous);

/// Maps any state to a command: axes in −1…1, lifts in 0…1. The mode switch selects foot (A), trunk (middle) or hand
/// (B) of `side`; the trigger stops, T3 retraces, T4 goes home.
[[nodiscard]] Command av8r_command(const Av8rState& state, Side side, const Av8rMapping& mapping = {});

}  // namespace baton
