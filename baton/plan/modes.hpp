/// The modes of a run.
#pragma once

#include "baton/plan/planner.hpp"

namespace baton {

/// What happens to a goal that cannot be verified.
enum class OnLimit {
  discard,  ///< the command is refused
  shrink,   ///< the goal comes nearer, along its direction, until it can
};

/// When the committed motion may be replaced.
enum class Gait {
  stop,  ///< when it has come to rest
  flow,  ///< on its way, from where it is then, moving
};

struct Modes {
  DurationRule duration = DurationRule::paper;
  OnLimit on_limit = OnLimit::shrink;
  Gait gait = Gait::flow;
};

}  // namespace baton
