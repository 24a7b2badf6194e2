#include "baton/balance/sole_wrenches.hpp"

namespace baton {

SoleWrenches::SoleWrenches(const RobotModel& robot)
    : robot_(&robot), jacobian_(6, robot.nv()), ddq_(VecX::Zero(robot.nv())), force_(VecX::Zero(robot.nv())) {}

BySide<Wrench> SoleWrenches::estimate(const BodyMotion& motion, const VecX& torque, Kinematics& kinematics) {
  ddq_.head<3>() = motion.acceleration;
  ddq_.segment<3>(3) = motion.angular_accel;
  ddq_.tail(robot_->nv() - 6) = motion.ddq;
  kinematics.inverse_dynamics(motion.q, motion.dq, ddq_, force_);
  BySide<Wrench> wrenches;
  for (const Side side : kSides) {
    const Pose sole = kinematics.sole(side);
    kinematics.sole_jacobian(side, jacobian_);
    Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
    Vec6 asked = Vec6::Zero();
    for (const int j : robot_->leg(side)) {
      const Vec6 column = jacobian_.col(6 + j);
      const double damping = robot_->joints()[static_cast<std::size_t>(j)].motor.damping;
      gram += column * column.transpose();
      asked += column * (force_[6 + j] + damping * motion.dq[6 + j] - torque[j]);
    }
    const Vec6 wrench = gram.ldlt().solve(asked);
    if (!wrench.allFinite()) continue;
    wrenches[side] = {sole.R.transpose() * wrench.head<3>(), sole.R.transpose() * wrench.tail<3>()};
  }
  return wrenches;
}

}  // namespace baton
