#include "baton/input/pad.hpp"

#include <array>
#include <utility>

namespace baton {

Part pad_guide(const PadState& state, Part previous) {
  const std::array<std::pair<bool, Part>, 5> choices{{{state.a, Part::trunk},
                                                      {state.x, Part::left_foot},
                                                      {state.b, Part::right_foot},
                                                      {state.y, Part::left_hand},
                                                      {state.right_shoulder, Part::right_hand}}};
  int pressed = 0;
  Part guide = previous;
  for (const auto& [held, part] : choices) {
    if (!held) continue;
    ++pressed;
    guide = part;
  }
  return pressed == 1 ? guide : previous;
}

Command pad_command(const PadState& state, Part guide, const PadMapping& mapping) {
  const auto pair = [](bool plus, bool minus) { return static_cast<int>(plus) - static_cast<int>(minus); };
  Command command;
  command.guide = guide;
  command.axes << mapping.stick(-state.left_down), mapping.stick(-state.left_right),
      mapping.stick(-state.right_down),  //
      pair(state.right, state.left), pair(state.up, state.down), mapping.stick(-state.right_right);
  command.lift = {mapping.trigger(state.left_trigger), mapping.trigger(state.right_trigger)};
  command.recall = recall_of(state.stick, state.back, state.start);
  return command;
}

}  // namespace baton
