#include "bench/scripts.hpp"

#include <algorithm>

#include "bench/draw.hpp"

namespace baton::bench {
namespace {

Vec6 random_axes(Draw& draw) {
  Vec6 axes = Vec6::Zero();
  const double kind = draw.real(0.0, 1.0);
  if (kind < 0.35) {
    axes[draw.below(6)] = draw.chance(0.5) ? 1.0 : -1.0;
  } else if (kind < 0.7) {
    for (const int axis : {0, 1})
      axes[axis] = draw.real(-1.0, 1.0);
  } else {
    for (double& axis : axes)
      axis = draw.real(-1.0, 1.0);
  }
  return axes;
}

}  // namespace

std::vector<Stretch> random_script(std::uint64_t seed, double seconds) {
  Draw draw(seed);
  std::vector<Stretch> script;
  Command command;
  double t = 0.0;
  while (t < seconds) {
    if (draw.chance(0.5)) command.guide = kParts[static_cast<std::size_t>(draw.below(5))];
    command.axes = draw.chance(0.2) ? Vec6(Vec6::Zero()) : random_axes(draw);
    if (draw.chance(0.4)) {
      for (const Side side : kSides)
        command.lift[side] = draw.chance(0.6) ? 0.0 : draw.real(0.2, 1.0);
    }
    t += draw.chance(0.3) ? draw.real(0.1, 0.5) : draw.real(0.5, 4.0);
    script.push_back({std::min(t, seconds), command});
  }
  return script;
}

}  // namespace baton::bench
