#include "baton/balance/stabiliser.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "baton/math/quintic.hpp"

namespace baton {
namespace {

constexpr double kIntegralTime = 3.0;  ///< integral time of the servo's torque [1/ω]
constexpr double kLeakTime = 12.0;     ///< time constant of the integral's leak [1/ω]
constexpr double kLeadTime = 0.04;     ///< low-pass of how far motors are sent past their links [1/ω]
constexpr double kZmpTime = 0.5;       ///< low-pass of the ZMP difference [1/ω]
constexpr double kOffsetFirst = 1.2;   ///< low-pass of the COM offset at first [1/ω]
constexpr double kOffsetTime = 12.0;   ///< the same at last
constexpr double kSettling = 3.0;      ///< longest wait for the COM offset, after a start [1/ω]
constexpr double kSettled = 0.22;      ///< distance of the ZMP from its average, if settled [half-width of a sole]
constexpr double kMostOffset = 0.12;   ///< bound of the COM offset [COM height]
constexpr double kOffsetBand = 0.072;  ///< dead band of the COM offset [half-width of a sole]
constexpr double kNear = 0.03;         ///< distance of a joint from the plan at a start that is no jump [rad]
constexpr double kApproach = 0.3;    ///< speed at which a joint that is farther off comes to the plan, at most [rad/s]
constexpr double kLeastLoad = 0.5;   ///< least load on the soles for comparing ZMPs, share of the weight
constexpr double kWholeLoad = 0.75;  ///< load from which the legs carry the whole robot, share of the weight

/// Moments by the trunk's errors of attitude and rate [weight × COM height per rad, per ω].
struct TrunkGains {
  double attitude, rate;
};
constexpr TrunkGains kStiffTrunk{2.0, 1.0};
constexpr TrunkGains kWaist{0.5, 0.4};  ///< a pelvis below a waist shakes with more

/// Whether joints lie between the root, which the legs carry, and the trunk.
bool has_waist(const RobotModel& robot) {
  return robot.dofs_to(robot.trunk_body()).size() > 6;
}

}  // namespace

Stabiliser::Stabiliser(const RobotModel& robot)
    : robot_(&robot),
      kinematics_(robot),
      footing_(robot),
      distribution_(robot),
      friction_(robot),
      scale_(robot),
      waist_(has_waist(robot)),
      averaged_(kOffsetFirst) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  commanded_ = lead_ = apart_ = servo_error_ = integral_torque_ = unloaded_ = learned_ = modelled_ = zero;
  target_ = {zero, zero, zero, zero, {}, zero};
  for (int j = 0; j < robot.nv() - 6; ++j) {
    const auto moves = [&](Side side) { return std::ranges::count(robot.dofs_to(robot.foot_body(side)), 6 + j) > 0; };
    if (!moves(Side::left) && !moves(Side::right)) upper_.push_back(j);
  }
}

const JointTarget& Stabiliser::target(const MotionSample& now, const MotionSample& next, const State& state,
                                      double stands, double play) {
  const Profile& profile = robot_->profile();
  const double omega = robot_->omega();
  correction_.dcm_error = state.dcm(omega) - (now.com + now.dcom / omega);
  const bool begins = std::exchange(first_, false);
  // While joints are led to the plan, they say nothing of ground, motors and COM.
  if (!begins && stands >= 1.0 && apart_.isZero(0.0)) {
    footing_.follow(now, next, state, wanted_);
    update_joints(now, state);
    compare_zmp(now, state);
  }
  kinematics_.set(next.q);
  const Mat3 trunk = kinematics_.trunk().R;
  const Vec2 moment = begins ? Vec2(Vec2::Zero()) : stands * attitude_moment(trunk, state);
  trunk_ = trunk;
  Wrench total = ground_wrench(kinematics_, next.force);

  // p_cmd = p + (1 + k/ω)(ξ_m − ξ_ref), clamped to the region: by a horizontal force at the COM, which leaves the
  // moment about the COM as planned.
  const Vec2 planned_zmp = next.zmp + correction_.com_offset;
  const Vec2 wish = planned_zmp + stands * (1.0 + profile.stabiliser.k_dcm / omega) * correction_.dcm_error.head<2>();
  const Vec2 balanced = next.zmp_region->nearest(wish);
  const double vertical = total.force.z();
  const Vec2 push = -vertical / (next.com.z() - next.zmp_height) * (balanced - planned_zmp);
  const Vec3 force(push.x(), push.y(), 0.0);
  total = with_com_offset(total, correction_.com_offset);
  total.force += force;
  total.moment += next.com.cross(force);
  // The trunk's attitude, by a moment, with the room that is left for the ZMP.
  correction_.zmp = next.zmp_region->nearest(balanced + Vec2(-moment.y(), moment.x()) / vertical);
  const Vec2 turn = correction_.zmp - balanced;
  const Vec3 turning = Vec3(turn.x(), turn.y(), 0).cross(Vec3(0, 0, vertical));
  total.moment += turning;

  const int n = robot_->nv() - 6;
  for (int j = 0; j < n; ++j) {
    const double damping = robot_->joints()[static_cast<std::size_t>(j)].motor.damping;
    learned_[j] = learned_torque(j, next.dq[6 + j]);
    unloaded_[j] = next.force[6 + j] + damping * next.dq[6 + j] + learned_[j];
  }
  carry_upper_body(force, turning);
  BySide<Wrench> shared = distribution_.share(kinematics_, next.sole, next.contact, total, unloaded_);
  if (stands < 1.0) scale_ankle_moments(kinematics_, stands, shared);
  for (const Side side : kSides)
    wanted_[side] = {shared[side].force, shared[side].moment_about(next.sole[side].p)};
  subtract_contact(kinematics_, shared, target_.tau = unloaded_);
  for (int j = 0; j < n; ++j) {  // the torque scale
    double& torque = target_.tau[j];
    modelled_[j] = torque - learned_[j];
    const double most = std::max(std::abs(torque), robot_->joints()[static_cast<std::size_t>(j)].motor.stall);
    torque = std::clamp(torque + scale_.excess() * modelled_[j], -most, most);
  }
  target_.q = next.q.tail(n);
  target_.dq = next.dq.tail(n);
  target_.ddq = next.ddq.tail(n);
  target_.contact = next.contact;
  footing_.apply(kinematics_, next.q, commanded_);
  if (begins && stands >= 1.0) {  // who hangs has been led to its stance
    apart_ = state.q.tail(n) - commanded_;
    apart_ = (apart_.array().abs() > kNear).select(apart_, 0.0);
    approaching_ = 0.0;
  }
  approach_plan();
  if (!apart_.isZero(0.0)) correction_.settling = true;
  lead_through_play(stands * play);
  target_.q_correction = commanded_ + lead_ - target_.q;
  return target_;
}

void Stabiliser::lead_through_play(double play) {
  const double follows = std::min(1.0, robot_->omega() * robot_->profile().tick.period / kLeadTime);
  for (Eigen::Index j = 0; j < lead_.size(); ++j) {
    // At most by what its torque deflects the servo, so that a small torque that changes sign does not shake the joint.
    const double kp = robot_->joints()[static_cast<std::size_t>(j)].gains.kp;
    const double most = std::min(play, std::abs(target_.tau[j]) / kp);
    if (!std::isfinite(most)) continue;
    lead_[j] += follows * (std::copysign(most, target_.tau[j]) - lead_[j]);
  }
}

void Stabiliser::approach_plan() {
  const double farthest = apart_.lpNorm<Eigen::Infinity>();
  if (farthest == 0.0) return;
  const double duration = 1.875 * farthest / kApproach;  // the blend's peak rate is 1.875 of the mean
  const Jet blend = smooth_step(approaching_, duration);
  commanded_ += (1.0 - blend.x) * apart_;
  target_.dq -= blend.dx * apart_;
  if (approaching_ >= duration) apart_.setZero();
  approaching_ += robot_->profile().tick.period;
}

void Stabiliser::carry_upper_body(const Vec3& force, const Vec3& moment) {
  if (force.isZero(0.0) && moment.isZero(0.0)) return;
  // As if it turned and moved as one with the body.
  const Vec3 turn = kinematics_.inertia().ldlt().solve(moment);
  const Vec3 push = force / robot_->mass() - turn.cross(kinematics_.com() - kinematics_.body(1).p);
  kinematics_.add_rigid_acceleration(push, turn, upper_, unloaded_);
}

double Stabiliser::spare_torque(int joint) const {
  const double share = 1.0 - robot_->profile().margin.torque;
  return share * robot_->joints()[static_cast<std::size_t>(joint)].motor.stall;
}

double Stabiliser::learned_torque(int joint, double planned_speed) const {
  const double most = spare_torque(joint);
  return std::clamp(integral_torque_[joint] + friction_.torque(joint, planned_speed), -most, most);
}

Vec2 Stabiliser::attitude_moment(const Mat3& trunk, const State& state) const {
  const double unit = robot_->mass() * kGravity * robot_->profile().stance.com_height;
  const Vec3 rate = rotation_error(trunk, trunk_) / robot_->profile().tick.period - state.trunk_rate;
  const TrunkGains& gains = waist_ ? kWaist : kStiffTrunk;
  const Vec3 moment = gains.attitude * rotation_error(trunk_, state.trunk) + gains.rate / robot_->omega() * rate;
  return unit * moment.head<2>();
}

void Stabiliser::compare_zmp(const MotionSample& now, const State& state) {
  Wrench total;
  for (const Side side : kSides) {
    total.force += state.force[side].force;
    total.moment += state.force[side].moment + state.sole[side].p.cross(state.force[side].force);
  }
  if (total.force.z() < kLeastLoad * robot_->mass() * kGravity) return;
  const Vec2 measured = total.zmp(support_plane(now.sole, now.contact));
  const Vec2 deficit = correction_.zmp - measured;
  correction_.zmp_deficit +=
      robot_->omega() * robot_->profile().tick.period / kZmpTime * (deficit - correction_.zmp_deficit);
  update_com_offset(now, measured);
}

void Stabiliser::update_com_offset(const MotionSample& now, const Vec2& measured) {
  const double height = robot_->profile().stance.com_height;
  const double sole = robot_->sole_half_width();
  const double period = robot_->omega() * robot_->profile().tick.period;  // [1/ω]
  const double follows = period / averaged_;
  averaged_ = std::min(averaged_ + period, kOffsetTime);
  const Eigen::Rotation2Dd heading(mean_yaw(now.sole));
  const Vec2 off = heading.inverse() * (measured - now.zmp);
  correction_.settling = averaged_ < kOffsetFirst + kSettling && (off - steady_zmp_).norm() > kSettled * sole;
  steady_zmp_ = bounded(Vec2(steady_zmp_ + follows * (off - steady_zmp_)), kMostOffset * height);
  correction_.com_offset = heading * beyond(steady_zmp_, kOffsetBand * sole);
}

void Stabiliser::reset() {
  correction_ = {};
  footing_ = Footing(*robot_);
  integral_torque_.setZero();
  lead_.setZero();
  friction_ = JointFriction(*robot_);
  scale_ = TorqueScale(*robot_);
  first_ = true;
  apart_.setZero();
  steady_zmp_.setZero();
  averaged_ = kOffsetFirst;
}

void Stabiliser::update_joints(const MotionSample& now, const State& state) {
  const double period = robot_->omega() * robot_->profile().tick.period;  // [1/ω]
  const int n = robot_->nv() - 6;
  servo_error_ = commanded_ - state.q.tail(n);
  friction_.update(now.dq.tail(n), servo_error_);
  const double carried = state.force.left.force.z() + state.force.right.force.z();
  if (carried > kWholeLoad * robot_->mass() * kGravity) scale_.update(modelled_, servo_error_);
  for (int j = 0; j < n; ++j) {
    const Joint& joint = robot_->joints()[static_cast<std::size_t>(j)];
    const double most = spare_torque(j);
    integral_torque_[j] +=
        period * (joint.gains.kp * servo_error_[j] / kIntegralTime - integral_torque_[j] / kLeakTime);
    integral_torque_[j] = std::clamp(integral_torque_[j], -most, most);
  }
}

}  // namespace baton
