/// Goal and posture → verified motion, or the reason why there is none.
#pragma once

#include "baton/plan/planned_motion.hpp"
#include "baton/plan/retrace.hpp"
#include "baton/plan/segment.hpp"
#include "baton/plan/survey.hpp"
#include "baton/verify/verifier.hpp"

namespace baton {

/// How the duration of a motion is found (docs/theory.md §4).
enum class DurationRule {
  paper,   ///< the first that passes of T, T + ΔT, …
  search,  ///< the shortest that passes
};

class Planner {
 public:
  /// Robot and world must outlive the object.
  Planner(const RobotModel& robot, const World& world, DurationRule rule = DurationRule::paper);

  /// For one duration after another: VRP knots that keep the ZMP inside the supports; a survey of the motion, which
  /// tells the limbs' part in the ZMP; the knots again, corrected by it; inverse kinematics and verification at every
  /// tick. What speaks against a candidate says whether a longer duration may mend it and which; what none mends
  /// (collision, joint limit, reach) ends the search. A pure function of its arguments.
  /// @param anchor planning frame in the world
  [[nodiscard]] PlanResult plan(const Posture& from, const Goal& goal, const Pose& anchor, const Limits& limits) {
    return plan(from, goal, anchor, limits, rule_);
  }
  [[nodiscard]] PlanResult plan(const Posture& from, const Goal& goal, const Pose& anchor, const Limits& limits,
                                DurationRule rule);

  /// The way back along an executed motion, verified again.
  [[nodiscard]] PlanResult retrace(const Trail& trail, const Pose& anchor, const Limits& limits);

  /// From a posture on the way back, moving, to a rest on it: to the very joint angles that the rest of the way back
  /// begins with.
  [[nodiscard]] PlanResult halt(const Posture& from, const Trail& trail, const Halt& halt, const Pose& anchor,
                                const Limits& limits);

  /// A part of the way back, and the rest where it ends.
  struct PartOfWay {
    PlannedMotion planned;  ///< its `limit` is what speaks against going on
    Halt halt;
  };
  /// The way back to the last rest on it before what speaks against the whole of it; none if there is no such rest.
  /// @param against the refusal of the whole way back
  [[nodiscard]] std::optional<PartOfWay> retrace_part(const Trail& trail, const Pose& anchor, const Limits& limits,
                                                      Refusal against);

 private:
  /// What speaks against a candidate, and the factor on its duration that may mend it; 0: none does.
  struct Failure {
    Refusal refusal;
    double stretch = 0.0;
  };
  /// A search for the duration of one segment.
  struct Task {
    const Segment& segment;
    const Pose& anchor;
    std::vector<VecX> looked{};  ///< postures of the last survey: where the next one starts from
    int tried = 0;               ///< durations looked at
    std::optional<Refusal> not_shorter{};
  };
  struct Candidate {
    Timing timing;
    ComPath com{};
  };

  [[nodiscard]] PlanResult by_paper(Task& task);
  [[nodiscard]] PlanResult by_search(Task& task);

  [[nodiscard]] static Failure judged(Refusal refusal, const Segment& segment);
  /// Finds the COM path of a candidate and looks along it.
  [[nodiscard]] std::optional<Failure> look(Task& task, Candidate& candidate);
  /// The same candidate worked out and verified at every tick.
  [[nodiscard]] std::variant<PlannedMotion, Failure> finish(const Task& task, const Candidate& candidate);
  /// How to divide a duration: as near to the shares as the point mass can do it, on the way to the division of the
  /// shortest.
  [[nodiscard]] std::optional<Timing> timing(const Segment& segment, const Timing& shortest, int ticks);
  /// A candidate with its joint paths; a refusal if inverse kinematics cannot follow.
  [[nodiscard]] std::variant<Motion, Refusal> realise(const Segment& segment, const Candidate& candidate);

  const RobotModel* robot_;
  DurationRule rule_;
  BoundedCom com_;
  Survey survey_;
  InverseKinematics ik_;
  Kinematics kinematics_;
  Verifier verifier_;
};

}  // namespace baton
