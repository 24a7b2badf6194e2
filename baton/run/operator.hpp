/// Interface to the source of commands: an input device, a script or a program.
#pragma once

#include "baton/guide/command.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/robot/robot.hpp"

namespace baton {

class Operator {
 public:
  /// What an operator can see of a run between two ticks.
  struct View {
    double t = 0.0;                ///< [s]
    const Navigator& navigator;    ///< after the last tick
    const Truth* truth = nullptr;  ///< the robot seen from outside; null if it has no truth
  };

  virtual ~Operator() = default;

  /// Returns the command for the next tick. Called once per tick.
  [[nodiscard]] virtual Command decide(const View& view) = 0;
};

}  // namespace baton
