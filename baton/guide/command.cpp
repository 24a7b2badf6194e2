#include "baton/guide/command.hpp"

#include <algorithm>
#include <cmath>

namespace baton {

Command sanitised(const Command& command) {
  Command result = command;
  for (double& axis : result.axes)
    axis = std::isnan(axis) ? 0.0 : std::clamp(axis, -1.0, 1.0);
  for (const Side side : kSides) {
    const double lift = command.lift[side];
    result.lift[side] = std::isnan(lift) ? 0.0 : std::clamp(lift, 0.0, 1.0);
  }
  return result;
}

}  // namespace baton
