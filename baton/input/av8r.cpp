#include "baton/input/av8r.hpp"

namespace baton {
namespace {

enum Axis : std::size_t { kStickRight, kStickAft, kLever1, kTwistRight, kLever2 };
enum Button : std::size_t {
  kTrigger = 0,
  kLauncher = 1,
  kMain = 2,
  kT1 = 4,
  kT2 = 5,
  kT3 = 6,
  kT4 = 7,
  kModeA = 12,
  kModeB = 13
};

Part guided_part(const Av8rState& state, Side side) {
  const bool a = state.buttons[kModeA];
  const bool b = state.buttons[kModeB];
  if (a == b) return Part::trunk;
  return a ? foot(side) : hand(side);
}

}  // namespace

Side av8r_side(const Av8rState& state, Side previous) {
  const bool left = state.buttons[kLauncher];
  const bool right = state.buttons[kMain];
  if (left == right) return previous;
  return left ? Side::left : Side::right;
}

Command av8r_command(const Av8rState& state, Side side, const Av8rMapping& mapping) {
  const auto stick = [&](Axis axis, double sign) { return mapping.stick(sign * state.axes[axis]); };
  const auto lever = [&](Axis axis) { return mapping.lever(0.5 * (1.0 + mapping.lever_forward * state.axes[axis])); };
  const int up = static_cast<int>(state.buttons[kT1]) - static_cast<int>(state.buttons[kT2]);
  Command command;
  command.guide = guided_part(state, side);
  command.axes << state.hat_up, -state.hat_right, up,  //
      stick(kStickRight, 1.0), stick(kStickAft, -1.0), stick(kTwistRight, -1.0);
  command.lift = {lever(kLever1), lever(kLever2)};
  command.recall = recall_of(state.buttons[kTrigger], state.buttons[kT3], state.buttons[kT4]);
  return command;
}

}  // namespace baton
