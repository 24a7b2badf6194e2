/// Goal and posture → verified motion, or the reason why there is none.
#pragma once

#include "baton/plan/segment.hpp"
#include "baton/verify/verifier.hpp"

namespace baton {

using PlanResult = std::variant<Motion, Refusal>;

class Planner {
 public:
  /// Robot and world must outlive the object.
  Planner(const RobotModel& robot, const World& world);

  /// The paper's duration correction (docs/theory.md §4): the first of T, T + ΔT, … ≤ T_max whose motion passes
  /// the point mass's ZMP check, inverse kinematics and verification. A failure that no longer duration mends
  /// (collision, joint limit, reach) ends the search. A pure function of its arguments.
  /// @param anchor planning frame in the world
  [[nodiscard]] PlanResult plan(const Posture& from, const Goal& goal, const Pose& anchor);

 private:
  /// A quick look along a candidate, a few postures only: what certainly fails is not worth more.
  [[nodiscard]] std::optional<Refusal> survey(const Segment& segment, const Posture& from, const Motion& motion);
  /// Joint paths of a candidate; a refusal if inverse kinematics cannot follow.
  [[nodiscard]] std::optional<Refusal> realise(const Segment& segment, const Posture& from, Motion& motion);

  const RobotModel* robot_;
  InverseKinematics ik_;
  Verifier verifier_;
};

}  // namespace baton
