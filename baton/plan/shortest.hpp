/// Shortest feasible duration of a segment for the point mass (docs/theory.md §4).
#pragma once

#include "baton/plan/com_plan.hpp"

namespace baton {

struct Shortest {
  Timing timing;
  ComPath path;
};

/// The fewest ticks, with the best division into phases: the shortest swing, and the remaining time split optimally
/// before and after it. A cheap bound guides the search; the quadratic program decides.
/// @param swing the swing phase; none: no foot moves
/// @param least_swing shortest swing [ticks]
/// @param longest longest duration tried [ticks]
/// @returns none: even `longest` is infeasible
/// @throws std::invalid_argument more than 16 knots
[[nodiscard]] std::optional<Shortest> shortest_timing(BoundedCom& com, const ComProblem& problem,
                                                      std::optional<std::size_t> swing, int least_swing, int longest,
                                                      double period);

}  // namespace baton
