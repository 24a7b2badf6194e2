#include "baton/balance/stabiliser.hpp"

#include <algorithm>
#include <utility>

namespace baton {
namespace {

// Times are the same for any size of robot.
constexpr double kIntegrates = 0.5;  ///< time in which the integral grows as large as the servo's torque [s]
constexpr double kForgets = 2.0;     ///< time constant with which it leaks away [s]
constexpr double kOfLate = 0.08;     ///< time over which commanded and measured ZMP are compared [s]
constexpr double kCarried = 0.5;     ///< with less of the weight on the soles they are not compared

}  // namespace

Stabiliser::Stabiliser(const RobotModel& robot)
    : robot_(&robot), kinematics_(robot), footing_(robot), distribution_(robot) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  planned_ = integral_ = zero;
  target_ = {zero, zero, zero, zero, {}, zero};
}

const JointTarget& Stabiliser::target(const MotionSample& now, const MotionSample& next, const State& state) {
  const Profile& profile = robot_->profile();
  const double omega = robot_->omega();
  correction_.dcm_error = state.dcm(omega) - (now.com + now.dcom / omega);
  if (!std::exchange(first_, false)) {
    footing_.follow(now, next, state, wanted_);
    integrate(state);
    compare(now, state);
  }
  kinematics_.set(next.q);
  Wrench total = ground_wrench(kinematics_, next.force);

  // p_cmd = p + (1 + k/ω)(ξ_m − ξ_ref), kept inside the support; the wrench is turned so that it meets it.
  const Vec2 wish = next.zmp + (1.0 + profile.stabiliser.k_dcm / omega) * correction_.dcm_error.head<2>();
  correction_.zmp = next.zmp_region->nearest(wish);
  const Vec2 shift = correction_.zmp - next.zmp;
  total.moment += Vec3(shift.x(), shift.y(), 0).cross(Vec3(0, 0, total.force.z()));

  const BySide<Wrench> shared = distribution_.share(next.sole, next.contact, total);
  for (const Side side : kSides)
    wanted_[side] = {shared[side].force, shared[side].moment_about(next.sole[side].p)};
  joint_torques(kinematics_, next.force, shared, target_.tau);
  const int n = robot_->nv() - 6;
  target_.q = next.q.tail(n);
  target_.dq = next.dq.tail(n);
  target_.ddq = next.ddq.tail(n);
  target_.contact = next.contact;
  footing_.apply(kinematics_, next.q, planned_);
  target_.shift = planned_ - target_.q;
  for (int j = 0; j < n; ++j) {
    target_.tau[j] += robot_->joints()[static_cast<std::size_t>(j)].motor.damping * target_.dq[j] + integral_[j];
  }
  return target_;
}

void Stabiliser::compare(const MotionSample& now, const State& state) {
  Wrench total;
  for (const Side side : kSides) {
    total.force += state.force[side].force;
    total.moment += state.force[side].moment + state.sole[side].p.cross(state.force[side].force);
  }
  if (total.force.z() < kCarried * robot_->mass() * kGravity) return;
  const Vec2 lacks = correction_.zmp - total.zmp(support_plane(now.sole, now.contact));
  correction_.lacks += robot_->profile().tick.period / kOfLate * (lacks - correction_.lacks);
}

void Stabiliser::reset() {
  correction_ = {};
  footing_ = Footing(*robot_);
  integral_.setZero();
  first_ = true;
}

void Stabiliser::integrate(const State& state) {
  const double period = robot_->profile().tick.period;
  const double share = 1.0 - robot_->profile().margin.torque;  // what verified motions leave of the stall torque
  const int n = robot_->nv() - 6;
  for (int j = 0; j < n; ++j) {
    const Joint& joint = robot_->joints()[static_cast<std::size_t>(j)];
    const double error = planned_[j] - state.q[7 + j];
    const double most = share * joint.motor.stall;
    integral_[j] += period * (joint.gains.kp * error / kIntegrates - integral_[j] / kForgets);
    integral_[j] = std::clamp(integral_[j], -most, most);
  }
}

}  // namespace baton
