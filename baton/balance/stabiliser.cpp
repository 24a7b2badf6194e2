#include "baton/balance/stabiliser.hpp"

#include <algorithm>
#include <utility>

namespace baton {
namespace {

constexpr double kIntegralTime = 3.0;  ///< integral time of the servo's torque [1/ω]
constexpr double kLeakTime = 12.0;     ///< time constant of the integral's leak [1/ω]
constexpr double kZmpTime = 0.5;       ///< low-pass of the ZMP difference [1/ω]
constexpr double kLeastLoad = 0.5;     ///< least load on the soles for comparing ZMPs, share of the weight

}  // namespace

Stabiliser::Stabiliser(const RobotModel& robot)
    : robot_(&robot), kinematics_(robot), footing_(robot), distribution_(robot) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  commanded_ = integral_torque_ = zero;
  target_ = {zero, zero, zero, zero, {}, zero};
}

const JointTarget& Stabiliser::target(const MotionSample& now, const MotionSample& next, const State& state) {
  const Profile& profile = robot_->profile();
  const double omega = robot_->omega();
  correction_.dcm_error = state.dcm(omega) - (now.com + now.dcom / omega);
  if (!std::exchange(first_, false)) {
    footing_.follow(now, next, state, wanted_);
    update_integral(state);
    compare_zmp(now, state);
  }
  kinematics_.set(next.q);
  Wrench total = ground_wrench(kinematics_, next.force);

  // p_cmd = p + (1 + k/ω)(ξ_m − ξ_ref), clamped to the region; the moment is changed so that the ZMP becomes p_cmd.
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
  footing_.apply(kinematics_, next.q, commanded_);
  target_.q_correction = commanded_ - target_.q;
  for (int j = 0; j < n; ++j) {
    target_.tau[j] += robot_->joints()[static_cast<std::size_t>(j)].motor.damping * target_.dq[j] + integral_torque_[j];
  }
  return target_;
}

void Stabiliser::compare_zmp(const MotionSample& now, const State& state) {
  Wrench total;
  for (const Side side : kSides) {
    total.force += state.force[side].force;
    total.moment += state.force[side].moment + state.sole[side].p.cross(state.force[side].force);
  }
  if (total.force.z() < kLeastLoad * robot_->mass() * kGravity) return;
  const Vec2 deficit = correction_.zmp - total.zmp(support_plane(now.sole, now.contact));
  correction_.zmp_deficit +=
      robot_->omega() * robot_->profile().tick.period / kZmpTime * (deficit - correction_.zmp_deficit);
}

void Stabiliser::reset() {
  correction_ = {};
  footing_ = Footing(*robot_);
  integral_torque_.setZero();
  first_ = true;
}

void Stabiliser::update_integral(const State& state) {
  const double period = robot_->omega() * robot_->profile().tick.period;  // [1/ω]
  const double share = 1.0 - robot_->profile().margin.torque;  // of the stall torque, left over by verified motions
  const int n = robot_->nv() - 6;
  for (int j = 0; j < n; ++j) {
    const Joint& joint = robot_->joints()[static_cast<std::size_t>(j)];
    const double error = commanded_[j] - state.q[7 + j];
    const double most = share * joint.motor.stall;
    integral_torque_[j] += period * (joint.gains.kp * error / kIntegralTime - integral_torque_[j] / kLeakTime);
    integral_torque_[j] = std::clamp(integral_torque_[j], -most, most);
  }
}

}  // namespace baton
