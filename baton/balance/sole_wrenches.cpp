#include "baton/balance/sole_wrenches.hpp"

namespace baton {
namespace {

// Standard deviations of what the least squares rest on.
constexpr double kForce = 0.05;     ///< of the whole body's force by inverse dynamics: masses, pushes [weight]
constexpr double kMoment = 0.1;     ///< of its moment: payloads, pulls at a hand [weight × COM height]
constexpr double kFriction = 0.05;  ///< of a motor torque [stall torque]
constexpr double kInTheAir = 0.3;   ///< of force and moment on a sole that is planned in the air, as the two above
constexpr double kHeldUp = 0.5;     ///< load by the legs below which somebody else carries the robot [weight]

/// The six numbers of one sole.
template <class Vector>
auto of_sole(Vector&& unknowns, Side side) {
  return unknowns.template segment<6>(side == Side::left ? 0 : 6);
}

}  // namespace

SoleWrenches::SoleWrenches(const RobotModel& robot)
    : robot_(&robot),
      jacobian_{JacobianRows(6, robot.nv()), JacobianRows(6, robot.nv())},
      ddq_(VecX::Zero(robot.nv())),
      force_(VecX::Zero(robot.nv())) {
  unit_.head<3>().setConstant(robot.mass() * kGravity);
  unit_.tail<3>() = robot.profile().stance.com_height * unit_.head<3>();
}

BySide<Wrench> SoleWrenches::estimate(const BodyMotion& motion, const VecX& torque, const BySide<bool>& planned,
                                      Kinematics& kinematics) {
  const BySide<Wrench> legs = by_legs(motion, torque, kinematics);
  double load = 0.0;
  for (const Side side : kSides)
    load += (kinematics.sole(side).R * legs[side].force).z();
  if (!(load >= kHeldUp * unit_[0])) return legs;
  for (int i = 0; i < 6; ++i)
    add(i, force_[i], unit_[i] * (i < 3 ? kForce : kMoment));
  for (const Side side : kSides) {
    if (!planned[side]) of_sole(gram_.diagonal(), side).array() += 1.0 / (kInTheAir * kInTheAir);
  }
  return solution(kinematics);
}

BySide<Wrench> SoleWrenches::by_legs(const BodyMotion& motion, const VecX& torque, Kinematics& kinematics) {
  ddq_.head<3>() = motion.acceleration;
  ddq_.segment<3>(3) = motion.angular_accel;
  ddq_.tail(robot_->nv() - 6) = motion.ddq;
  kinematics.inverse_dynamics(motion.q, motion.dq, ddq_, force_);
  for (const Side side : kSides)
    kinematics.sole_jacobian(side, jacobian_[side]);
  gram_.setZero();
  asked_.setZero();
  for (Eigen::Index j = 0; j < torque.size(); ++j) {  // of those outside the legs, the Jacobians are zero
    const Motor& motor = robot_->joints()[static_cast<std::size_t>(j)].motor;
    add(6 + j, force_[6 + j] + motor.damping * motion.dq[6 + j] - torque[j], kFriction * motor.stall);
  }
  return solution(kinematics);
}

void SoleWrenches::add(Eigen::Index dof, double force, double error) {
  Vec12 row;
  for (const Side side : kSides)
    of_sole(row, side) = unit_.cwiseProduct(jacobian_[side].col(dof));
  const Vec12 weighted = row / (error * error);
  gram_ += weighted * row.transpose();
  asked_ += weighted * force;
}

BySide<Wrench> SoleWrenches::solution(const Kinematics& kinematics) const {
  const Vec12 found = gram_.ldlt().solve(asked_);
  BySide<Wrench> wrenches;
  if (!found.allFinite()) return wrenches;
  for (const Side side : kSides) {
    const Vec6 wrench = unit_.cwiseProduct(of_sole(found, side));
    const Mat3 axes = kinematics.sole(side).R.transpose();
    wrenches[side] = {axes * wrench.head<3>(), axes * wrench.tail<3>()};
  }
  return wrenches;
}

}  // namespace baton
