/// Trials as tests want them.
#pragma once

#include "baton/proving/episode.hpp"

namespace baton::test {

inline Trial trial(Simulation::On on, std::uint64_t seed, double seconds, Modes modes = {}) {
  Trial trial;
  trial.on = on;
  trial.seed = seed;
  trial.seconds = seconds;
  trial.modes = modes;
  return trial;
}

}  // namespace baton::test
