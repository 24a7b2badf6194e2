/// Goal and posture → verified motion, or a refusal.
#pragma once

#include "baton/plan/planned_motion.hpp"
#include "baton/plan/retrace.hpp"
#include "baton/plan/segment.hpp"
#include "baton/plan/survey.hpp"
#include "baton/verify/verifier.hpp"

namespace baton {

/// How the duration of a motion is found (docs/theory.md §4).
enum class DurationRule {
  paper,   ///< the first feasible of T, T + ΔT, …
  search,  ///< the shortest feasible
};

class Planner {
 public:
  /// `robot` and `world` must outlive this object.
  Planner(const RobotModel& robot, const World& world, DurationRule rule = DurationRule::paper);

  /// Tries durations in turn. For each: VRP knots that keep the ZMP inside the supports; a coarse survey, which yields
  /// the limbs' contribution to the ZMP; the knots corrected for it; inverse kinematics and verification at every tick.
  /// The refusal of a candidate tells whether, and by how much, a longer duration may help; one that time cannot mend
  /// (collision, joint limit, reach) ends the search. A pure function of its arguments.
  /// @param anchor planning frame in the world frame
  [[nodiscard]] PlanResult plan(const Posture& from, const Goal& goal, const Pose& anchor, const Limits& limits) {
    return plan(from, goal, anchor, limits, rule_);
  }
  [[nodiscard]] PlanResult plan(const Posture& from, const Goal& goal, const Pose& anchor, const Limits& limits,
                                DurationRule rule);

  /// Number of durations tried so far, for all plans: a measure of work that does not depend on the computer.
  [[nodiscard]] long tried() const { return tried_; }

  /// Retraces an executed motion; the reversed motion is verified again.
  /// @param heat of the motors at its start
  [[nodiscard]] PlanResult retrace(const Trail& trail, const Pose& anchor, const Limits& limits, const Heat& heat = {});

  /// Brings a moving robot on a retrace path to a planned rest on that path, ending at exactly the joint angles from
  /// which the remaining path continues.
  [[nodiscard]] PlanResult halt(const Posture& from, const Trail& trail, const TrailRest& halt, const Pose& anchor,
                                const Limits& limits);

  /// Part of a retrace path, and the planned rest at its end.
  struct PartOfWay {
    PlannedMotion planned;  ///< `limit` is why it does not go further
    TrailRest halt;
  };
  /// The retrace path up to the last planned rest before the point of failure; none if there is no such rest.
  /// @param against refusal of the whole path
  /// @param heat of the motors at its start
  [[nodiscard]] std::optional<PartOfWay> retrace_part(const Trail& trail, const Pose& anchor, const Limits& limits,
                                                      Refusal against, const Heat& heat = {});

 private:
  /// Why a candidate failed, and the factor on its duration that may help; 0: none.
  struct Failure {
    Refusal refusal;
    double stretch = 0.0;
  };
  /// Duration search for one segment.
  struct Task {
    const Segment& segment;
    const Pose& anchor;
    std::vector<VecX> warm_start{};  ///< postures of the last survey, to warm-start the next
    int tried = 0;                   ///< number of durations
    std::optional<Refusal> not_shorter{};
  };
  struct Candidate {
    Timing timing;
    ComPath com{};
  };

  [[nodiscard]] PlanResult by_paper(Task& task);
  [[nodiscard]] PlanResult by_search(Task& task);

  [[nodiscard]] static Failure judged(Refusal refusal, const Segment& segment);
  /// Finds the COM path of a candidate and surveys it.
  [[nodiscard]] std::optional<Failure> evaluate(Task& task, Candidate& candidate);
  /// Realises the candidate at every tick and verifies it.
  [[nodiscard]] std::variant<PlannedMotion, Failure> finish(const Task& task, const Candidate& candidate);
  /// Divides a duration into phases: between the default shares and the division of the shortest timing, as close to
  /// the default shares as is feasible for the point mass.
  [[nodiscard]] std::optional<Timing> timing(const Segment& segment, const Timing& shortest, int ticks);
  /// Computes joint paths; a refusal if inverse kinematics fails.
  [[nodiscard]] std::variant<Motion, Refusal> realise(const Segment& segment, const Candidate& candidate);

  const RobotModel* robot_;
  DurationRule rule_;
  BoundedCom com_;
  Survey survey_;
  InverseKinematics ik_;
  Kinematics kinematics_;
  Verifier verifier_;
  long tried_ = 0;
};

}  // namespace baton
