#include "baton/balance/stabiliser.hpp"

namespace baton {

Stabiliser::Stabiliser(const RobotModel& robot) : robot_(&robot), kinematics_(robot) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  target_ = {zero, zero, zero, zero, {}};
}

const JointTarget& Stabiliser::target(const MotionSample& now, const MotionSample& next, const State& state) {
  const Profile& profile = robot_->profile();
  const double omega = robot_->omega();
  kinematics_.set(next.q);
  Wrench total = ground_wrench(kinematics_, next.force);

  // p_cmd = p + (1 + k/ω)(ξ_m − ξ_ref), kept inside the support; the wrench is turned so that it meets it.
  correction_.dcm_error = state.dcm(omega) - (now.com + now.dcom / omega);
  const Vec2 wish = next.zmp + (1.0 + profile.stabiliser.k_dcm / omega) * correction_.dcm_error.head<2>();
  correction_.zmp = next.zmp_region->nearest(wish);
  const Vec2 shift = correction_.zmp - next.zmp;
  total.moment += Vec3(shift.x(), shift.y(), 0).cross(Vec3(0, 0, total.force.z()));

  const BySide<Wrench> shared = share_wrench(*robot_, next.sole, next.contact, total);
  joint_torques(kinematics_, next.force, shared, target_.tau);
  const int n = robot_->nv() - 6;
  target_.q = next.q.tail(n);
  target_.dq = next.dq.tail(n);
  target_.ddq = next.ddq.tail(n);
  target_.contact = next.contact;
  for (int j = 0; j < n; ++j) {
    target_.tau[j] += robot_->joints()[static_cast<std::size_t>(j)].motor.damping * target_.dq[j];
  }
  return target_;
}

}  // namespace baton
