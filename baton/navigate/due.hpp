/// Which planning task is due now: a pure function of what is executed, what is measured, and the command.
#pragma once

#include "baton/balance/stabiliser.hpp"
#include "baton/guide/arm_trajectory.hpp"
#include "baton/navigate/course.hpp"
#include "baton/navigate/exchange.hpp"
#include "baton/navigate/history.hpp"
#include "baton/navigate/watch.hpp"
#include "baton/plan/modes.hpp"

namespace baton {

/// Everything that a request depends on.
struct Situation {
  const RobotModel& robot;
  const World& world;
  Gait gait;
  const Course& course;
  const History& history;
  const Watch& watch;
  const Correction& correction;  ///< of the stabiliser, in this tick
  const Exchange& exchange;
  const LastRefusal& refused;
  const Command& command;
  const ArmTrajectory& arms;
  long tick;
};

/// The request that is due, if one is: a capture step or a stop when the robot is pushed; on the way of a motion, where
/// it can go on or the stick asks for something else; at rest, or when the motion is about to end, what the command
/// asks for, unless the same was refused at the same place. With hot motors, nothing but what lets them cool, and
/// stops.
[[nodiscard]] std::optional<Request> due(const Situation& now);

/// The request that `command` would be, from where the robot rests next.
[[nodiscard]] Request request_from_rest(const Situation& now, const Command& command);

}  // namespace baton
