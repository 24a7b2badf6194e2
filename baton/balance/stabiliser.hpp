/// Planned sample and measured state → joint target: feed-forward torque, with a bounded correction of the
/// contact wrench (docs/theory.md §6).
#pragma once

#include "baton/balance/footing.hpp"
#include "baton/balance/wrench_distribution.hpp"

namespace baton {

/// What the stabiliser asked for, to be recorded and shown.
struct Correction {
  Vec3 dcm_error = Vec3::Zero();  ///< measured − planned [m]
  Vec2 zmp = Vec2::Zero();        ///< commanded ZMP, in the planning frame [m]
  Vec2 lacks = Vec2::Zero();      ///< commanded − measured ZMP of late: what the ground does not give [m]
};

class Stabiliser {
 public:
  /// The robot must outlive the object.
  explicit Stabiliser(const RobotModel& robot);

  /// @param now planned sample at the time of the measurement
  /// @param next planned sample at the end of this tick
  [[nodiscard]] const JointTarget& target(const MotionSample& now, const MotionSample& next, const State& state);

  /// Forgets what it has learnt of ground and motors.
  void reset();

  [[nodiscard]] const Footing& footing() const { return footing_; }
  [[nodiscard]] const Correction& correction() const { return correction_; }

 private:
  const RobotModel* robot_;
  /// How far the ZMP has come of where it was to be.
  void compare(const MotionSample& now, const State& state);
  /// What keeps the joints at their angles on the long run: torque that grows with the error.
  void integrate(const State& state);

  Kinematics kinematics_;
  Footing footing_;
  WrenchDistribution distribution_;
  VecX planned_;           ///< joint angles that were to be reached by now, footing included [rad]
  VecX integral_;          ///< [N·m]
  BySide<Wrench> wanted_;  ///< of each sole, moment about its centre
  bool first_ = true;
  JointTarget target_;
  Correction correction_;
};

}  // namespace baton
