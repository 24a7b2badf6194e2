/// What there is to record: one tick, one answer of the planner.
#pragma once

#include "baton/navigate/navigator.hpp"
#include "baton/robot/robot.hpp"

namespace baton {

/// One tick: the state before the target of this tick is written.
struct TickRecord {
  double t = 0.0;  ///< [s]
  const Navigator& navigator;
  const Measurement& measurement;
  const Truth& truth;
  const JointTarget& target;
  double tick_us = 0.0;  ///< thread CPU time of Navigator::tick [µs]
};

/// One answer of the planner.
struct PlanRecord {
  double t = 0.0;  ///< when it was asked for [s]
  const Request& request;
  const Answer& result;
  double plan_us = 0.0;  ///< thread CPU time [µs]
};

}  // namespace baton
