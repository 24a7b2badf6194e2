/// Contact wrench on each sole, estimated without force sensors: from the motor torques of the legs, the balance of the
/// whole body, and the contacts that are planned.
#pragma once

#include "baton/model/contact.hpp"

namespace baton {

class SoleWrenches {
 public:
  /// The robot must outlive the object.
  explicit SoleWrenches(const RobotModel& robot);

  /// Motion of the robot.
  struct BodyMotion {
    const VecX& q;               ///< configuration (nq); the root's position does not matter
    const VecX& dq;              ///< velocity (nv)
    Vec3 acceleration;           ///< of the root's origin, in the world [m/s²]
    Vec3 angular_accel;          ///< of the root, in the root frame [rad/s²]
    Eigen::Ref<const VecX> ddq;  ///< of the joints (n) [rad/s²]
  };

  /// Contact wrenches in the sole frames, moment about the sole's centre: weighted least squares of the equations of
  /// motion (docs/theory.md §6). Those of `by_legs` if the legs carry less than half of the weight, as when the robot
  /// is held up. Zero if an input is not finite.
  /// @param torque motor torques (n) [N·m]
  /// @param planned planned contacts
  /// @param kinematics gets set to `motion.q`
  [[nodiscard]] BySide<Wrench> estimate(const BodyMotion& motion, const VecX& torque, const BySide<bool>& planned,
                                        Kinematics& kinematics);
  /// The same from the torques alone, each leg by itself: for a motion whose accelerations were not measured. Without
  /// meaning for a leg that is singular.
  [[nodiscard]] BySide<Wrench> by_legs(const BodyMotion& motion, const VecX& torque, Kinematics& kinematics);

 private:
  /// Unknowns: force [weight] and moment [weight × COM height] on the left, then on the right sole, in world axes.
  using Vec12 = Eigen::Matrix<double, 12, 1>;
  using Mat12 = Eigen::Matrix<double, 12, 12>;

  /// Adds the equation of a degree of freedom.
  /// @param force generalised force that the contacts give there
  /// @param error its standard deviation
  void add(Eigen::Index dof, double force, double error);
  [[nodiscard]] BySide<Wrench> solution(const Kinematics& kinematics) const;

  const RobotModel* robot_;
  Vec6 unit_;  ///< of force and moment [N], [N·m]
  BySide<JacobianRows> jacobian_;
  VecX ddq_;
  VecX force_;
  Mat12 gram_;
  Vec12 asked_;
};

}  // namespace baton
