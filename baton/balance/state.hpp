/// Measurement → state: the actual state of the robot, in the planning frame.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Measured state, in the planning frame.
struct State {
  VecX q;                          ///< configuration (nq)
  Vec3 com = Vec3::Zero();         ///< [m]
  Vec3 dcom = Vec3::Zero();        ///< [m/s]
  Mat3 trunk = Mat3::Identity();   ///< attitude
  Vec3 trunk_rate = Vec3::Zero();  ///< angular velocity [rad/s]
  BySide<Pose> sole;
  double age = 0.0;      ///< of the measurement [s]
  BySide<Wrench> force;  ///< contact wrench on each sole, in the axes of the planning frame, moment about its centre

  /// Divergent component of motion [m].
  [[nodiscard]] Vec3 dcm(double omega) const { return com + dcom / omega; }
};

class Estimator {
 public:
  /// The robot must outlive the object.
  explicit Estimator(const RobotModel& robot);

  /// Updates the state by forward kinematics from the measured root.
  /// @param anchor planning frame in the world
  /// @param known the same joints and attitude of the root, which is at the origin; null: not known
  /// @throws std::invalid_argument the measurement has no root pose (`Odometry` adds one)
  [[nodiscard]] const State& update(const Measurement& measurement, const Pose& anchor,
                                    const Kinematics* known = nullptr);

 private:
  const RobotModel* robot_;
  Kinematics kinematics_;
  JacobianRows jacobian_;
  VecX dq_;
  State state_;
};

/// Displacement of the planning frame (position and yaw, in that frame) that best aligns the planned soles with the
/// measured ones: their middle, and the mean of their yaw.
/// @param contact soles to align
[[nodiscard]] Pose anchor_correction(const BySide<Pose>& planned, const BySide<Pose>& measured,
                                     const BySide<bool>& contact);

}  // namespace baton
