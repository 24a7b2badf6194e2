/// Port for whoever gives the commands: a device in somebody's hands, a script, a program.
#pragma once

#include "baton/guide/command.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/robot/robot.hpp"

namespace baton {

class Operator {
 public:
  /// What an operator may see of a run, between two ticks.
  struct View {
    double t = 0.0;                ///< [s]
    const Navigator& navigator;    ///< as the last tick left it
    const Truth* truth = nullptr;  ///< of the robot, seen from outside; null if it has none
  };

  virtual ~Operator() = default;

  /// The command of the next tick. Called once before each.
  [[nodiscard]] virtual Command decide(const View& view) = 0;
};

}  // namespace baton
