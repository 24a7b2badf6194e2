/// Reproduces figures of the 2008 paper with the planner, and a test of walking.
#pragma once

#include <filesystem>

namespace baton::app {

/// Fig. 8, duration correction: two steps to the right, the second of which needs more time to keep the ZMP inside the
/// support. Writes `fig8.json` and `fig8.svg`.
/// @throws InputError a file cannot be written
int reproduce_fig8(const std::filesystem::path& out);

/// The demonstration in the room, by the stick alone.
int reproduce_room(const std::filesystem::path& out);

/// Thirteen walks of a minute each: forward, sideways, turning, steps, replanning. Reports the trunk's tilt, and the
/// distance from each walk's end to where its motions would have led without slip. Fails above 10° or 3 cm.
int reproduce_walks(const std::filesystem::path& out);

}  // namespace baton::app
