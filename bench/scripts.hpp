/// Random stick scripts.
#pragma once

#include <cstdint>
#include <vector>

#include "baton/guide/command.hpp"

namespace baton::bench {

/// A command held until a given time.
struct Stretch {
  double until = 0.0;  ///< from the start of the script [s]
  Command command;
};

/// A random script: one or all axes, full or half deflection, held for seconds or moved quickly; guided parts change at
/// any time; feet are lifted. A seed gives the same script on every platform.
[[nodiscard]] std::vector<Stretch> random_script(std::uint64_t seed, double seconds);

}  // namespace baton::bench
