#include "baton/balance/force_check.hpp"

#include <algorithm>
#include <cmath>

#include "baton/balance/check_limits.hpp"

namespace baton {
namespace {

constexpr double kLoad = 10.0;      ///< largest contact force [weight], and moment [weight × COM height]
constexpr double kLightLoad = 0.3;  ///< load of a sole below which its centre of pressure says nothing [weight]
constexpr double kBeyond = 0.15;    ///< how far beyond its sole a centre of pressure may be measured [COM height]
constexpr double kUnplanned = 0.4;  ///< difference from the plan from which motor torques are asked [weight]
constexpr double kUnfelt = 0.6;     ///< difference from what they tell, of forces that are wrong [weight]
constexpr double kImpact = 0.092;   ///< how long an impact lasts that motor torques do not tell [1/ω]
constexpr double kStuckLoad = 0.2;  ///< difference from the plan, of forces that do not change [weight]
constexpr double kTorque = 1.5;     ///< largest motor torque, as currents tell it [stall torque]

double difference(const BySide<double>& a, const BySide<double>& b) {
  return std::max(std::abs(a.left - b.left), std::abs(a.right - b.right));
}

}  // namespace

ForceCheck::ForceCheck(const RobotModel& robot)
    : robot_(&robot),
      period_(robot.profile().tick.period),
      weight_(robot.mass() * kGravity),
      kinematics_(robot),
      wrenches_(robot),
      q_(VecX::Zero(robot.nq())) {}

bool ForceCheck::forces_accepted(const Measurement& measurement, const MotionSample& planned) {
  const BySide<Wrench>& sole = measurement.sole;
  const bool zero = sole.left.force.isZero(0.0) && sole.right.force.isZero(0.0);  // lifted, or without such sensors
  same_ = sole == last_ && !zero ? same_ + 1 : 0;
  last_ = sole;
  if (zero) return true;
  if (!in_range(sole)) return false;
  const BySide<double> measured{sole.left.force.z() / weight_, sole.right.force.z() / weight_};
  const BySide<double> expected = planned_load(planned);
  const double off = difference(measured, expected);
  if (same_ * period_ >= check::kSame && planned.dq.norm() > check::kMoves && off > kStuckLoad) return false;
  if (off <= kUnplanned || measurement.torque.size() == 0 || !torques_accepted(measurement.torque)) {
    unfelt_ = 0;
    return true;
  }
  const BySide<double> felt = felt_load(measurement, planned);
  const bool agrees = difference(measured, felt) <= kUnfelt || difference(felt, expected) > off;
  unfelt_ = agrees ? 0 : unfelt_ + 1;
  return unfelt_ * period_ * robot_->omega() < kImpact;
}

bool ForceCheck::torques_accepted(const VecX& torque) const {
  for (Eigen::Index j = 0; j < torque.size(); ++j) {
    if (!(std::abs(torque[j]) <= kTorque * robot_->joints()[static_cast<std::size_t>(j)].motor.stall)) return false;
  }
  return true;
}

BySide<Wrench> ForceCheck::planned_forces(const MotionSample& planned) {
  const BySide<Wrench> shared = planned_contact(planned);
  BySide<Wrench> wrenches;
  for (const Side side : kSides) {
    const Pose& sole = planned.sole[side];
    wrenches[side] = {sole.R.transpose() * shared[side].force, sole.R.transpose() * shared[side].moment_about(sole.p)};
  }
  return wrenches;
}

void ForceCheck::planned_torques(const MotionSample& planned, VecX& torque) {
  const BySide<Wrench> shared = planned_contact(planned);
  joint_torques(kinematics_, planned.force, shared, torque);
  for (Eigen::Index j = 0; j < torque.size(); ++j)
    torque[j] += robot_->joints()[static_cast<std::size_t>(j)].motor.damping * planned.dq[6 + j];
}

bool ForceCheck::in_range(const BySide<Wrench>& sole) const {
  const double height = robot_->profile().stance.com_height;
  for (const Side side : kSides) {
    const Wrench& wrench = sole[side];
    if (!(wrench.force.norm() <= kLoad * weight_ && wrench.moment.norm() <= kLoad * weight_ * height)) return false;
    const double load = std::max(wrench.force.z(), kLightLoad * weight_);
    const Vec2 pressure = Vec2(-wrench.moment.y(), wrench.moment.x()) / load;
    if (robot_->sole(side).margin(pressure) < -kBeyond * height) return false;
  }
  return true;
}

BySide<double> ForceCheck::planned_load(const MotionSample& planned) {
  if (!planned.contact.left) return {0.0, 1.0};
  if (!planned.contact.right) return {1.0, 0.0};
  const Vec2 across = (planned.sole.left.p - planned.sole.right.p).head<2>();
  const double left = across.dot(planned.zmp - planned.sole.right.p.head<2>()) / across.squaredNorm();
  return {std::clamp(left, 0.0, 1.0), 1.0 - std::clamp(left, 0.0, 1.0)};
}

BySide<double> ForceCheck::felt_load(const Measurement& measurement, const MotionSample& planned) {
  const Eigen::Index n = measurement.q.size();
  q_ = planned.q;
  q_.tail(n) = measurement.q;
  // Planned speeds, as those of encoders are noisy.
  const BySide<Wrench> felt =
      wrenches_.by_legs({q_, planned.dq, planned.ddq.head<3>(), planned.ddq.segment<3>(3), planned.ddq.tail(n)},
                        measurement.torque, kinematics_);
  return {felt.left.force.z() / weight_, felt.right.force.z() / weight_};
}

BySide<Wrench> ForceCheck::planned_contact(const MotionSample& planned) {
  kinematics_.set(planned.q);
  return share_wrench(*robot_, planned.sole, planned.contact, ground_wrench(kinematics_, planned.force));
}

}  // namespace baton
