/// Figures of the 2008 paper, made anew by the planner itself.
#pragma once

#include <filesystem>

namespace baton::app {

/// Fig. 8, duration correction: two steps to the right; the second needs more time, else the ZMP leaves the
/// support. Writes `fig8.json` and `fig8.svg`.
/// @throws InputError a file cannot be written
int reproduce_fig8(const std::filesystem::path& out);

/// The demonstration in the room, by stick alone.
int reproduce_room(const std::filesystem::path& out);

}  // namespace baton::app
