#include "baton/robot/ideal_robot.hpp"

namespace baton {

IdealRobot::IdealRobot(const RobotModel& robot, const Posture& start, double period)
    : robot_(&robot), start_(start), period_(period), kinematics_(robot), sole_(start.sole) {
  sensor_ = robot.imu_in_root().value_or(Pose{});
  torque_ = VecX::Zero(robot.nv() - 6);
  truth_.q = start.q;
  truth_.dq = VecX::Zero(robot.nv());
  measure_ground(truth_.dq);
}

void IdealRobot::reset() {
  *this = IdealRobot(*robot_, start_, period_);
}

Measurement IdealRobot::read() {
  Measurement m;
  m.t = truth_.t;
  m.q = truth_.q.tail(robot_->nv() - 6);
  m.dq = truth_.dq.tail(robot_->nv() - 6);
  kinematics_.set(truth_.q);
  const Pose root = kinematics_.body(1);
  m.root = RootMeasurement{root, truth_.dq.head<3>(), truth_.dq.segment<3>(3)};
  m.torque = torque_;
  m.imu.attitude = root.R * sensor_.R;
  m.imu.rate = sensor_.R.transpose() * m.root->rate;
  m.imu.acceleration = m.imu.attitude.transpose() * (acceleration_ + Vec3(0, 0, kGravity));
  for (const Side side : kSides) {
    const Pose to_sole = sole_[side].inverse();
    m.sole[side] = {to_sole.R * truth_.sole[side].force, to_sole.R * truth_.sole[side].moment_about(sole_[side].p)};
  }
  return m;
}

void IdealRobot::write(const JointTarget& target) {
  const int n = robot_->nv() - 6;
  const VecX dq_before = truth_.dq;
  contact_ = target.contact;
  if (contact_.left != contact_.right) planted_ = contact_.left ? Side::left : Side::right;
  truth_.q.tail(n) = target.q;
  truth_.dq.tail(n) = target.dq;

  // Root pose and velocity follow from the planted sole being at rest.
  kinematics_.set(truth_.q);
  const Pose root = sole_[planted_] * kinematics_.sole(planted_).inverse() * kinematics_.body(1);
  set_root(truth_.q, root);
  kinematics_.set(truth_.q);
  JacobianRows rows(6, robot_->nv());
  const int body = robot_->foot_body(planted_);
  kinematics_.point_jacobian(body, sole_[planted_].p, rows.topRows(3));
  kinematics_.rotation_jacobian(body, rows.bottomRows(3));
  truth_.dq.head<6>() = -rows.leftCols(6).partialPivLu().solve(rows.rightCols(n) * target.dq);
  for (const Side side : kSides)
    sole_[side] = kinematics_.sole(side);

  truth_.t += period_;
  torque_ = target.tau;
  const Vec3 velocity = sensor_velocity(root.R);
  acceleration_ = (velocity - velocity_) / period_;
  velocity_ = velocity;
  measure_ground((truth_.dq - dq_before) / period_);
}

Vec3 IdealRobot::sensor_velocity(const Mat3& root) const {
  return truth_.dq.head<3>() + root * truth_.dq.segment<3>(3).cross(sensor_.p);
}

void IdealRobot::measure_ground(const VecX& ddq) {
  VecX force(robot_->nv());
  kinematics_.inverse_dynamics(truth_.q, truth_.dq, ddq, force);
  truth_.sole = share_wrench(*robot_, sole_, contact_, ground_wrench(kinematics_, force));
  truth_.touch = contact_;
}

}  // namespace baton
