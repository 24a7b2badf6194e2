/// Interface to observers of a run: traces, reports, recordings, judges.
#pragma once

#include <functional>

#include "baton/navigate/navigator.hpp"
#include "baton/robot/robot.hpp"

namespace baton {

/// One tick, as it is before its target is written. Its events are in `Navigator::events`.
struct TickRecord {
  double t = 0.0;  ///< at the beginning of the tick [s]
  const Navigator& navigator;
  const Measurement& measurement;
  const Truth* truth;  ///< null if the robot has none
  const JointTarget& target;
  double tick_us = 0.0;  ///< CPU time of Navigator::tick [µs]
};

/// One answer of the planner.
struct PlanRecord {
  double t = 0.0;  ///< time at which the navigator receives it [s]
  const Request& request;
  const Answer& answer;
  double plan_us = 0.0;  ///< CPU time of planning [µs]
};

/// Calls between navigator and planner after a tick: `request` (ask) and `answer`.
enum class PlanningEvent { ask, answer };

class Sink {
 public:
  virtual ~Sink() = default;

  virtual void on_tick(const TickRecord& /*record*/) {}
  virtual void on_plan(const PlanRecord& /*record*/) {}
  virtual void on_planning(PlanningEvent /*event*/) {}
  /// Targets that drive the arms from the next tick on.
  virtual void on_arms(const ArmTargets& /*targets*/) {}
};

/// A sink made of functions; empty functions are skipped.
class Hooks : public Sink {
 public:
  std::function<void(const TickRecord&)> tick;
  std::function<void(const PlanRecord&)> plan;

  void on_tick(const TickRecord& record) override {
    if (tick) tick(record);
  }
  void on_plan(const PlanRecord& record) override {
    if (plan) plan(record);
  }
};

}  // namespace baton
