/// Arming of a live input device: its commands count once its controls have been released since it was connected.
#pragma once

#include <cstdint>

#include "baton/guide/command.hpp"

namespace baton {

/// Whether the command asks for nothing, whichever part is guided. Stricter than `Command::neutral`: a raised throttle
/// would lift its foot as soon as that foot is guided.
[[nodiscard]] inline bool controls_released(const Command& command) {
  return command.recall == Recall::none && command.axes.isZero(0.0) && command.lift.left == 0.0 &&
         command.lift.right == 0.0;
}

/// A device that reconnects may have a wrong zero or be held deflected, so its controls must be released first.
class Arming {
 public:
  enum class State : std::uint8_t {
    absent,   ///< not connected, or silent
    waiting,  ///< connected, not yet released
    armed,    ///< its commands count
  };

  /// Updates with one reading: whether the device is present and all its controls are released.
  State update(bool present, bool released) {
    switch (state_) {
      case State::absent:
      case State::waiting:
        state_ = !present ? State::absent : released ? State::armed : State::waiting;
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
