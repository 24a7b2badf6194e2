/// When the commands of a live device begin to count: after it was neutral once since it appeared.
#pragma once

#include <cstdint>

#include "baton/guide/command.hpp"

namespace baton {

/// Whether nothing is asked for, by whichever part is guided: stricter than `Command::neutral`, for a throttle that is
/// still up would lift its foot as soon as that is guided.
[[nodiscard]] inline bool at_rest(const Command& command) {
  return command.recall == Recall::none && command.axes.isZero(0.0) && command.lift.left == 0.0 &&
         command.lift.right == 0.0;
}

/// A stick that comes back after a lost link may be zeroed wrongly, or be held deflected: it has to show
/// neutral first.
class Arming {
 public:
  enum class State : std::uint8_t {
    absent,   ///< nothing there, or silent
    waiting,  ///< there, and not yet neutral
    armed,    ///< its commands count
  };

  /// One reading: whether the device is there, and whether every control of it is at rest.
  State update(bool present, bool at_rest) {
    switch (state_) {
      case State::absent:
      case State::waiting:
        state_ = !present ? State::absent : at_rest ? State::armed : State::waiting;
        break;
      case State::armed:
        if (!present) state_ = State::absent;
        break;
    }
    return state_;
  }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool armed() const { return state_ == State::armed; }

 private:
  State state_ = State::absent;
};

}  // namespace baton
