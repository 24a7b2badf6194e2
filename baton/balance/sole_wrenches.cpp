#include "baton/balance/sole_wrenches.hpp"

namespace baton {
namespace {

// Standard deviations of what the least squares rest on.
constexpr double kBalance = 0.02;   ///< of the force [weight] and the moment [weight × COM height] of the whole body
constexpr double kFriction = 0.05;  ///< of a motor torque [stall torque]
constexpr double kInTheAir = 0.3;   ///< of the force on a sole that is planned in the air [weight]

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
  add_legs(motion, torque, kinematics);
  for (int i = 0; i < 6; ++i) {
    Vec12 column;
    for (const Side side : kSides)
      of_sole(column, side) = unit_.cwiseProduct(jacobian_[side].col(i));
    add(column, force_[i], kBalance * unit_[i]);
  }
  for (const Side side : kSides) {
    if (!planned[side]) of_sole(gram_.diagonal(), side).array() += 1.0 / (kInTheAir * kInTheAir);
  }
  return solution(kinematics);
}

BySide<Wrench> SoleWrenches::by_legs(const BodyMotion& motion, const VecX& torque, Kinematics& kinematics) {
  add_legs(motion, torque, kinematics);
  return solution(kinematics);
}

void SoleWrenches::add_legs(const BodyMotion& motion, const VecX& torque, Kinematics& kinematics) {
  ddq_.head<3>() = motion.acceleration;
  ddq_.segment<3>(3) = motion.angular_accel;
  ddq_.tail(robot_->nv() - 6) = motion.ddq;
  kinematics.inverse_dynamics(motion.q, motion.dq, ddq_, force_);
  gram_.setZero();
  asked_.setZero();
  for (const Side side : kSides) {
    kinematics.sole_jacobian(side, jacobian_[side]);
    for (const int j : robot_->leg(side)) {
      const Motor& motor = robot_->joints()[static_cast<std::size_t>(j)].motor;
      Vec12 column = Vec12::Zero();
      of_sole(column, side) = unit_.cwiseProduct(jacobian_[side].col(6 + j));
      add(column, force_[6 + j] + motor.damping * motion.dq[6 + j] - torque[j], kFriction * motor.stall);
    }
  }
}

void SoleWrenches::add(const Vec12& column, double value, double error) {
  const Vec12 weighted = column / (error * error);
  gram_ += weighted * column.transpose();
  asked_ += weighted * value;
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
