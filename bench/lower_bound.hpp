/// The shortest duration in which any point mass could do a segment, to judge a planner's by (docs/theory.md §4): "free
/// ZMP inside the polygons, exact terminal state" as a linear program, solved by Clp.
#pragma once

#include <optional>

#include "baton/plan/com_plan.hpp"

namespace baton::bench {

/// The fewest ticks with which the linear program is feasible.
///
/// Unknowns: the ZMP, constant on each of at least 100 equal intervals, inside the polygon of its phase by the
/// problem's margin, with no wish and no continuity asked for: what a planner's knots can do, this can do, but for the
/// intervals. The COM's height does not change, so that p̈ = (g/h)(p − zmp) with h = height over the plane.
///
/// The phases are divided as suits best, in whole ticks, at least one each: the swing as short as it may be, since the
/// stance sole lies in both double supports; where it begins is searched by branch and bound, whose bounds are the same
/// program with a swing shorter by as much as its beginning is unknown. Feasibility is taken to grow with the duration.
///
/// @param swing the phase in which a foot is in the air; none: no foot moves
/// @param least_swing [ticks]
/// @param longest [ticks]
/// @param guess where to look first [ticks]; of no influence on the answer
/// @returns none: not even `longest` will do
/// @throws std::invalid_argument the COM's height changes, or the single support is not in the double ones
[[nodiscard]] std::optional<int> least_ticks(const ComProblem& problem, std::optional<std::size_t> swing,
                                             int least_swing, int longest, double period, int guess = 0);

}  // namespace baton::bench
