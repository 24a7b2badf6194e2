/// The shortest duration in which the point mass can do a segment (docs/theory.md §4).
#pragma once

#include "baton/plan/com_plan.hpp"

namespace baton {

struct Shortest {
  Timing timing;
  ComPath path;
};

/// The fewest ticks, with the phases divided for it: the swing as short as it may be, and of the time beside it as much
/// before the swing as suits best. A bound that is cheap to evaluate says where to look; the quadratic program decides.
/// @param swing the phase in which a foot is in the air; none: no foot moves
/// @param least_swing shortest swing [ticks]
/// @param longest no duration beyond is tried [ticks]
/// @returns none: not even `longest` will do
/// @throws std::invalid_argument more than 16 knots
[[nodiscard]] std::optional<Shortest> shortest_timing(BoundedCom& com, const ComProblem& problem,
                                                      std::optional<std::size_t> swing, int least_swing, int longest,
                                                      double period);

}  // namespace baton
