/// Sticks moved at random, for runs that anything may happen in.
#pragma once

#include <cstdint>
#include <vector>

#include "baton/guide/command.hpp"

namespace baton::bench {

/// A command that holds until a time.
struct Stretch {
  double until = 0.0;  ///< from the start of the script [s]
  Command command;
};

/// What a hand on the stick does: one or all axes, full or half way, held for seconds or moved hastily; guided parts
/// changed at any time; feet lifted. The same seed gives the same script on every platform.
[[nodiscard]] std::vector<Stretch> random_script(std::uint64_t seed, double seconds);

}  // namespace baton::bench
