#include "baton/balance/imu_check.hpp"

#include <cmath>
#include <utility>

#include "baton/balance/check_limits.hpp"
#include "baton/balance/specific_force.hpp"

namespace baton {
namespace {

constexpr double kConfirm = 0.1;  ///< time for which attitude and gyro contradict each other before gravity decides [s]
constexpr double kDisagree = 0.035;     ///< turns of gyro and attitude in a tick: noise and delay [rad]
constexpr double kExcessTurn = 0.04;    ///< the same, added up [rad]
constexpr double kStuckExcess = 0.006;  ///< the same, for a gyro that gives the same again and again [rad]
constexpr double kTurns = 0.02;         ///< turn by the gyro that an attitude that does not change contradicts [rad]
constexpr double kAttitudeStray = 0.3;  ///< how fast the attitude leaves its prediction without a gyro [rad/s]
constexpr double kBetter = 0.02;        ///< difference of two directions of gravity that decides nothing [-]
constexpr double kGyroRange = 35.0;     ///< range of a gyro, 2000 deg/s [rad/s]
constexpr double kRateJump = 4.0;     ///< largest change of the gyro in a tick that the attitude need not show [rad/s]
constexpr double kRange = 160.0;      ///< range of an accelerometer, 16 g [m/s²]
constexpr double kExcessSpeed = 0.4;  ///< acceleration beyond the plan, added up: more than a push [m/s]
constexpr double kFreeFall = 3.0;     ///< specific force below which the robot may be falling freely [m/s²]
constexpr double kStuckForce = 0.5;   ///< error of an accelerometer that gives the same again and again [m/s²]

}  // namespace

ImuCheck::Accepted ImuCheck::check(const Measurement::Imu& imu, const MotionSample& planned) {
  const auto count = [this](int& ticks, bool same) { ticks = same && !first_ ? ticks + 1 : 0; };
  count(same_.attitude, imu.attitude == last_.attitude);
  count(same_.gyro, imu.rate == last_.rate);
  count(same_.accelerometer, imu.acceleration == last_.acceleration);

  Accepted accepted;
  const bool valid = check::is_rotation(imu.attitude);
  std::optional<Vec3> turn;
  if (std::exchange(valid_, valid) && valid) turn = rotation_log(last_.attitude.transpose() * imu.attitude);
  const Vec3 rate = in_root_.R.transpose() * planned.dq.segment<3>(3);
  accepted.gyro = gyro_accepted(imu.rate, rate, turn);
  imu_.rate = accepted.gyro ? imu.rate : rate;

  const Mat3 turned = rotation_exp(period_ * imu_.rate);
  const Mat3 predicted = first_ && valid ? imu.attitude : Mat3(imu_.attitude * turned);
  const Vec3 force = planned_force(predicted, planned);
  accepted.accelerometer = accelerometer_accepted(imu.acceleration, force, planned.dq.norm() > check::kMoves);
  imu_.acceleration = accepted.accelerometer ? imu.acceleration : force;

  const double follows = first_ ? 1.0 : period_ / check::kMemory;
  measured_force_ = turned.transpose() * measured_force_;
  // As measured, though the prediction contradicts it: else a wrong prediction would confirm itself.
  const bool in_range = imu.acceleration.norm() <= kRange;
  measured_force_ += follows * ((in_range ? imu.acceleration : force) - measured_force_);
  planned_force_ += follows * (planned_specific_force(planned) - planned_force_);
  accepted.attitude = attitude_accepted(imu.attitude, predicted);
  if (!accepted.attitude && valid && turned_.norm() <= kTurns && contradicted_ >= kConfirm &&
      gravity_agrees(imu.attitude, predicted, planned)) {
    turn_ = rotation_z(yaw_of(predicted) - yaw_of(imu.attitude));  // gravity does not tell the yaw: it goes on
    accepted.attitude = true;
  }
  imu_.attitude = accepted.attitude ? Mat3(turn_ * imu.attitude) : predicted;
  contradicted_ = accepted.attitude ? 0.0 : contradicted_ + period_;
  blind_ = accepted.attitude ? 0.0 : blind_ + (accepted.gyro ? 0.0 : period_);
  last_ = imu;
  first_ = false;
  return accepted;
}

void ImuCheck::predict(const MotionSample& planned) {
  imu_.rate = in_root_.R.transpose() * planned.dq.segment<3>(3);
  imu_.attitude = imu_.attitude * rotation_exp(period_ * imu_.rate);
  imu_.acceleration = planned_force(imu_.attitude, planned);
  contradicted_ += period_;
  blind_ += period_;
}

bool ImuCheck::gyro_accepted(const Vec3& rate, const Vec3& planned, const std::optional<Vec3>& turn) {
  if (!(rate.norm() <= kGyroRange)) return false;
  const bool stuck = same_.gyro * period_ >= check::kSame;
  bool agrees = false;
  excess_turn_ *= 1.0 - period_ / check::kMemory;
  if (turn) {
    const Vec3 excess = period_ * rate - *turn;
    agrees = excess.norm() <= kDisagree;
    // A sudden contradiction is a jump of one of them, and found as such.
    if (agrees) excess_turn_ += excess;
  }
  if (excess_turn_.norm() > (stuck ? kStuckExcess : kExcessTurn)) return false;
  return agrees || first_ || (rate - imu_.rate).norm() <= kRateJump || (rate - planned).norm() <= kRateJump;
}

bool ImuCheck::accelerometer_accepted(const Vec3& acceleration, const Vec3& planned, bool moves) {
  if (!(acceleration.norm() <= kRange)) return false;
  const Vec3 excess = acceleration - planned;
  if (same_.accelerometer * period_ >= check::kSame && moves && excess.norm() > kStuckForce) return false;
  excess_speed_ *= 1.0 - period_ / check::kMemory;
  if (acceleration.norm() > kFreeFall) excess_speed_ += period_ * excess;
  return excess_speed_.norm() <= kExcessSpeed;
}

bool ImuCheck::attitude_accepted(const Mat3& attitude, const Mat3& predicted) {
  const bool same = same_.attitude > 0;
  turned_ = same ? Vec3(turned_ + period_ * imu_.rate) : Vec3::Zero();
  return valid_ && turned_.norm() <= kTurns &&
         rotation_error(turn_ * attitude, predicted).norm() <= kDisagree + kAttitudeStray * blind_;
}

bool ImuCheck::gravity_agrees(const Mat3& attitude, const Mat3& predicted, const MotionSample& planned) const {
  const auto off = [&](const Mat3& R) {
    return (R * measured_force_ - heading(R, planned) * planned_force_).norm() / kGravity;
  };
  return off(attitude) < off(predicted) + kBetter;
}

Vec3 ImuCheck::planned_force(const Mat3& attitude, const MotionSample& planned) const {
  return attitude.transpose() * heading(attitude, planned) * planned_specific_force(planned);
}

Mat3 ImuCheck::heading(const Mat3& attitude, const MotionSample& planned) const {
  return heading_from_plan(attitude * in_root_.R.transpose(), planned);
}

}  // namespace baton
