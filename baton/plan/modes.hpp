/// Planning modes of a run.
#pragma once

#include "baton/plan/planner.hpp"

namespace baton {

/// What to do with a goal that has no verified motion.
enum class OnLimit {
  discard,  ///< refuse the command
  shrink,   ///< move the goal closer, along its direction, until it has one
};

/// When the committed motion may be replaced.
enum class Gait {
  stop,  ///< only at rest
  flow,  ///< also on its way, from the moving state
};

struct Modes {
  DurationRule duration = DurationRule::paper;
  OnLimit on_limit = OnLimit::shrink;
  Gait gait = Gait::flow;
};

}  // namespace baton
