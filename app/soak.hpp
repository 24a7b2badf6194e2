/// What the kinds of soak share.
#pragma once

#include "app/commands.hpp"
#include "baton/proving/episode.hpp"

namespace baton::app {

/// Writes the stick of an episode that went wrong, and says how to see it again.
/// @param seed of its plant and of what goes wrong with answers
void write_replay(const SoakOptions& options, const Episodes& episodes, const EpisodeResult& result, double period,
                  long seed);

}  // namespace baton::app
