/// The ground's wrench on each sole by the torques of the leg's motors, for a robot without force sensors.
#pragma once

#include "baton/model/contact.hpp"

namespace baton {

class SoleWrenches {
 public:
  /// The robot must outlive the object.
  explicit SoleWrenches(const RobotModel& robot);

  /// How the robot moves.
  struct Motion {
    const VecX& q;               ///< configuration (nq); where the root is does not matter
    const VecX& dq;              ///< (nv)
    Vec3 acceleration;           ///< of the root's origin, in the world [m/s²]
    Vec3 angular_accel;          ///< of the root, in its own frame [rad/s²]
    Eigen::Ref<const VecX> ddq;  ///< of the joints (n) [rad/s²]
  };

  /// Of each leg: what inverse dynamics asks of its joints and the motors do not give comes from the ground. In the
  /// sole's frame, moment about its centre; zero where the leg's posture does not tell.
  /// @param torque of the motors (n) [N·m]
  /// @param kinematics is set to `motion.q`
  [[nodiscard]] BySide<Wrench> estimate(const Motion& motion, const VecX& torque, Kinematics& kinematics);

 private:
  const RobotModel* robot_;
  JacobianRows jacobian_;
  VecX ddq_;
  VecX force_;
};

}  // namespace baton
