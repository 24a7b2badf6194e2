/// Lower bound on the duration of a segment for a point mass, to compare planners with (docs/theory.md §4): free ZMP
/// inside the polygons and an exact terminal state, as a linear program solved by Clp.
#pragma once

#include <optional>

#include "baton/plan/com_plan.hpp"

namespace baton::bench {

/// Fewest ticks for which the linear program is feasible.
///
/// Unknowns: the ZMP, constant on each of at least 100 equal intervals, inside the polygon of its phase with the
/// problem's margin. No desired path and no continuity: up to the discretisation, this includes everything a planner's
/// knots can do. The COM height is constant, so that p̈ = (g/h)(p − zmp) with h = COM height above the plane.
///
/// The division into phases is optimal, in whole ticks, at least one per phase. The swing takes its least time, since
/// the stance sole lies in both double supports. Its start is found by branch and bound; the bounds come from the same
/// program with the swing shortened by the uncertainty of its start. Assumes that feasibility is monotonic in the
/// duration.
///
/// @param swing the swing phase; none: no foot moves
/// @param least_swing [ticks]
/// @param longest [ticks]
/// @param guess start of the search [ticks]; does not affect the result
/// @returns none: even `longest` is infeasible
/// @throws std::invalid_argument the COM height changes, or single support is not contained in double support
[[nodiscard]] std::optional<int> least_ticks(const ComProblem& problem, std::optional<std::size_t> swing,
                                             int least_swing, int longest, double period, int guess = 0);

}  // namespace baton::bench
