/// Planning modes of a run.
#pragma once

#include <string_view>

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

/// The words for them in options, messages and files.
constexpr std::string_view to_string(DurationRule rule) {
  return rule == DurationRule::search ? "search" : "paper";
}
constexpr std::string_view to_string(OnLimit on_limit) {
  return on_limit == OnLimit::discard ? "discard" : "shrink";
}
constexpr std::string_view to_string(Gait gait) {
  return gait == Gait::stop ? "stop" : "flow";
}

}  // namespace baton
