/// Figures of the 2008 paper, made anew by the planner itself; and what such controllers are tested by.
#pragma once

#include <filesystem>

namespace baton::app {

/// Fig. 8, duration correction: two steps to the right; the second needs more time, else the ZMP leaves the
/// support. Writes `fig8.json` and `fig8.svg`.
/// @throws InputError a file cannot be written
int reproduce_fig8(const std::filesystem::path& out);

/// The demonstration in the room, by stick alone.
int reproduce_room(const std::filesystem::path& out);

/// Thirteen walks of a minute each: forward, sideways, turning, steps, replanning. How far the trunk tilts, and how far
/// each of them ends from where its motions would have led if no sole had slid. Fails above 10° and 3 cm.
int reproduce_walks(const std::filesystem::path& out);

}  // namespace baton::app
