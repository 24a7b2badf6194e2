/// Contact wrench on each sole, estimated from the motor torques of the leg, for a robot without force sensors.
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

  /// Contact wrenches in the sole frames, moment about the sole's centre. The contact gives what the joints of the leg
  /// need by inverse dynamics beyond their motor torques. Zero where the leg is singular.
  /// @param torque motor torques (n) [N·m]
  /// @param kinematics gets set to `motion.q`
  [[nodiscard]] BySide<Wrench> estimate(const BodyMotion& motion, const VecX& torque, Kinematics& kinematics);

 private:
  const RobotModel* robot_;
  JacobianRows jacobian_;
  VecX ddq_;
  VecX force_;
};

}  // namespace baton
