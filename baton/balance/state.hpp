/// Measurement → state: where the robot really is.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// In the planning frame.
struct State {
  VecX q;                          ///< configuration (nq)
  Vec3 com = Vec3::Zero();         ///< [m]
  Vec3 dcom = Vec3::Zero();        ///< [m/s]
  Mat3 trunk = Mat3::Identity();   ///< attitude
  Vec3 trunk_rate = Vec3::Zero();  ///< [rad/s]
  BySide<Pose> sole;
  BySide<Wrench> force;  ///< on each sole, axes of the planning frame, moment about the sole's centre

  /// Divergent component of motion [m].
  [[nodiscard]] Vec3 dcm(double omega) const { return com + dcom / omega; }
};

class Estimator {
 public:
  /// The robot must outlive the object.
  explicit Estimator(const RobotModel& robot);

  /// The state, by forward kinematics from the measured root.
  /// @param anchor planning frame in the world
  /// @throws std::invalid_argument the measurement has no root pose (docs/balance.md: odometry gives one)
  [[nodiscard]] const State& update(const Measurement& measurement, const Pose& anchor);

 private:
  const RobotModel* robot_;
  Kinematics kinematics_;
  JacobianRows jacobian_;
  VecX dq_;
  State state_;
};

/// Pose of the planning frame (position and yaw) for which the planned soles that stand lie best on the measured
/// ones: `correction` leads from the old planning frame to the new one.
[[nodiscard]] Pose anchor_correction(const BySide<Pose>& planned, const BySide<Pose>& measured,
                                     const BySide<bool>& contact);

}  // namespace baton
