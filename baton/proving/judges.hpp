/// What an episode is judged by, beside its report; each judge is a sink of the run.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>

#include "baton/proving/checker.hpp"
#include "baton/proving/tally.hpp"
#include "baton/run/session.hpp"

namespace baton {

/// What went wrong in an episode.
class Failures {
 public:
  /// Session and tally must outlive the object.
  Failures(const Session& session, long episode, Tally& tally)
      : session_(&session), episode_(episode), tally_(&tally) {}

  /// Counts a failure, of each kind one a segment at most.
  void add(const std::string& kind, double t, double value, double limit, const std::string& where);

 private:
  const Session* session_;
  long episode_;
  Tally* tally_;
  long segment_ = -1;            ///< the one that failed last
  std::set<std::string> kinds_;  ///< what it failed by
};

/// Checks every tick with the independent checker, if there is one.
class TickJudge : public Sink {
 public:
  /// Failures and tally must outlive the object.
  /// @param exact the robot follows its plan exactly: its truth is checked, else the plan
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

/// Records where the motions that can be retraced began, and compares where the motions back end.
class WayBack : public Sink {
 public:
  /// All must outlive the object.
  /// @param exact a motion back that is refused, or ends elsewhere, is a failure
  WayBack(const RobotModel& robot, bool exact, Failures& failures, Tally::Retrace& sum)
      : robot_(&robot), exact_(exact), failures_(&failures), sum_(&sum) {}

  /// From now on motions back are judged.
  void begin() { going_ = true; }
  [[nodiscard]] bool begun() const { return going_; }
  /// Whether a motion back is under way.
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
  std::deque<VecX> rests_;       ///< where the motions that can be retraced began
  long motion_ends_ = 0;         ///< the one under way, if nothing replaces it [tick]
  std::optional<VecX> back_to_;  ///< where the motion back that is under way shall end
  bool part_ = false;            ///< it goes only a part of the way there
};

/// Detects a robot that is stuck: for which no command has a motion.
class StuckJudge : public Sink {
 public:
  /// All must outlive the object.
  StuckJudge(const RobotModel& robot, const World& world, DurationRule rule, const Session& session, Failures& failures)
      : strategy_(robot, world, {rule, OnLimit::discard}), session_(&session), failures_(&failures) {}

  void on_plan(const PlanRecord& record) override;

  /// After every tick: tests once, at rest, after many refusals in a row.
  void look();
  /// Counts a failure if the robot is stuck where it rests next.
  void test();

 private:
  Strategy strategy_;
  const Session* session_;
  Failures* failures_;
  int refused_in_a_row_ = 0;
};

/// Whether no command at all, of many different ones and the way back, has a motion from there.
/// @param request from where the robot rests; its command does not matter
[[nodiscard]] bool stuck(Strategy& planning, Request request);

}  // namespace baton
