/// What the kinds of soak share.
#pragma once

#include "app/commands.hpp"
#include "app/episode.hpp"

namespace baton::app {

/// Replaces a file as a whole: whoever reads it finds the old or the new text.
/// @throws InputError it cannot be written
void write_whole(const std::filesystem::path& file, const std::string& text);

/// Writes the stick of an episode that went wrong, and says how to see it again.
/// @param seed of its plant and of what goes wrong with answers
void write_replay(const SoakOptions& options, const Episodes& episodes, const EpisodeResult& result, double period,
                  long seed);

}  // namespace baton::app
