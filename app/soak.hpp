/// Shared by all kinds of soak tests.
#pragma once

#include "app/commands.hpp"
#include "baton/proving/episode.hpp"

namespace baton::app {

/// Writes the stick of a failed episode and prints how to replay it.
/// @param seed seed of the plant and of answer faults
void write_replay(const SoakOptions& options, const Episodes& episodes, const EpisodeResult& result, double period,
                  long seed);

}  // namespace baton::app
