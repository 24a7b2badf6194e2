/// Planned sample and measured state → joint target: feed-forward torque, with a bounded correction of the
/// contact wrench (docs/theory.md §6).
#pragma once

#include "baton/balance/state.hpp"

namespace baton {

/// What the stabiliser asked for, to be recorded and shown.
struct Correction {
  Vec3 dcm_error = Vec3::Zero();  ///< measured − planned [m]
  Vec2 zmp = Vec2::Zero();        ///< commanded ZMP, in the planning frame [m]
};

class Stabiliser {
 public:
  /// The robot must outlive the object.
  explicit Stabiliser(const RobotModel& robot);

  /// @param now planned sample at the time of the measurement
  /// @param next planned sample at the end of this tick
  [[nodiscard]] const JointTarget& target(const MotionSample& now, const MotionSample& next, const State& state);

  [[nodiscard]] const Correction& correction() const { return correction_; }

 private:
  const RobotModel* robot_;
  Kinematics kinematics_;
  JointTarget target_;
  Correction correction_;
};

}  // namespace baton
