/// Commands: at random, and of one axis.
#pragma once

#include <random>

#include "baton/guide/command.hpp"

namespace baton::test {

/// Any part, a third of the axes centred, axes and lifts also a little beyond their ranges.
inline Command random_command(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.2, 1.2);
  Command command;
  command.guide = kParts[random() % kParts.size()];
  for (double& axis : command.axes)
    axis = random() % 3 == 0 ? 0.0 : unit(random);
  command.lift = {random() % 2 == 0 ? 0.0 : unit(random), random() % 2 == 0 ? 0.0 : unit(random)};
  return command;
}

/// One axis of a part deflected, all others centred.
inline Command push(Part part, int axis, double value = 1.0) {
  Command command{.guide = part};
  command.axes[axis] = value;
  return command;
}

}  // namespace baton::test
