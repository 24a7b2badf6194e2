/// Judges of an episode, in addition to its report; each is a sink of a run whose robot has truth.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>

#include "baton/proving/checker.hpp"
#include "baton/proving/tally.hpp"
#include "baton/run/session.hpp"

namespace baton {

/// Failures of an episode.
class Failures {
 public:
  /// `session` and `tally` must outlive this object.
  Failures(const Session& session, long episode, Tally& tally)
      : session_(&session), episode_(episode), tally_(&tally) {}

  /// Counts a failure, at most one of each kind per segment.
  void add(const std::string& kind, double t, double value, double limit, const std::string& where);

 private:
  const Session* session_;
  long episode_;
  Tally* tally_;
  long segment_ = -1;            ///< last segment that failed
  std::set<std::string> kinds_;  ///< kinds of its failures
};

/// Checks every tick with the independent checker, if any.
class TickJudge : public Sink {
 public:
  /// `failures` and `tally` must outlive this object.
  /// @param exact check the truth of a robot that tracks exactly; else check the plan
  TickJudge(std::optional<Checker> checker, bool exact, Failures& failures, Tally& tally)
      : checker_(std::move(checker)), exact_(exact), failures_(&failures), tally_(&tally) {}

  void on_tick(const TickRecord& record) override;

  /// Configuration at the last tick.
  [[nodiscard]] const VecX& last() const { return last_; }

 private:
  std::optional<Checker> checker_;
  bool exact_;
  Failures* failures_;
  Tally* tally_;
  Checker::Tick tick_;
  VecX last_;
};

/// Compares where retraced motions end with where the original motions began.
class WayBack : public Sink {
 public:
  /// All references must outlive this object.
  /// @param exact a retrace that is refused or ends elsewhere is a failure
  WayBack(const RobotModel& robot, bool exact, Failures& failures, Tally::Retrace& sum)
      : robot_(&robot), exact_(exact), failures_(&failures), sum_(&sum) {}

  /// Judge retraced motions from now on.
  void begin() { going_ = true; }
  [[nodiscard]] bool begun() const { return going_; }
  /// Whether a retrace is under way.
  [[nodiscard]] bool under_way() const { return back_to_.has_value(); }

  void on_tick(const TickRecord& record) override;
  void on_plan(const PlanRecord& record) override;

 private:
  void judge_end(double t, const VecX& q);

  const RobotModel* robot_;
  bool exact_;
  Failures* failures_;
  Tally::Retrace* sum_;
  bool going_ = false;
  std::deque<VecX> rests_;       ///< where the retraceable motions began
  long motion_ends_ = 0;         ///< end of the motion under way if not replaced [tick]
  std::optional<VecX> back_to_;  ///< where the retrace under way should end
  bool part_ = false;            ///< it retraces only part of the way
};

/// Detects a stuck robot: one for which no command has a motion.
class StuckJudge : public Sink {
 public:
  /// All references must outlive this object.
  StuckJudge(const RobotModel& robot, const World& world, DurationRule rule, const Session& session, Failures& failures)
      : strategy_(robot, world, {rule, OnLimit::discard}), session_(&session), failures_(&failures) {}

  void on_plan(const PlanRecord& record) override;

  /// Call after every tick: tests once, at rest, after many consecutive refusals.
  void look();
  /// Counts a failure if the robot is stuck in its next state of rest.
  void test();

 private:
  Strategy strategy_;
  const Session* session_;
  Failures* failures_;
  int refused_in_a_row_ = 0;
};

/// Whether none of many different commands, retrace included, has a motion from there.
/// @param request starts where the robot rests; its command is ignored
[[nodiscard]] bool stuck(Strategy& strategy, Request request);

}  // namespace baton
