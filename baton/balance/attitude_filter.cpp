#include "baton/balance/attitude_filter.hpp"

#include <utility>

#include "baton/balance/specific_force.hpp"

namespace baton {
namespace {

constexpr double kAttitudeRate = 0.03;  ///< at which roll and pitch follow the sensor's attitude [ω]
constexpr double kGravityRate = 0.1;    ///< at which roll and pitch follow the direction of gravity [ω]
constexpr double kTilted =
    0.05;  ///< bound of the tilt that gravity tells: what is beyond is acceleration, as by a push [rad]
constexpr double kWander = 0.15;  ///< fastest error of the sensor's attitude that is corrected by the gyro [rad/s]

}  // namespace

AttitudeFilter::AttitudeFilter(const Pose& imu_in_root, double period, double omega)
    : root_in_imu_(imu_in_root.R.transpose()),
      period_(period),
      rate_attitude_(kAttitudeRate * omega),
      rate_gravity_(kGravityRate * omega) {}

const Mat3& AttitudeFilter::update(const Measurement::Imu& imu, const MotionSample& planned) {
  const Mat3 last = std::exchange(last_, imu.attitude);
  if (std::exchange(first_, false)) return R_ = imu.attitude;
  // Where gyro and attitude turn differently, the attitude wanders, which is slow; faster, it is a fault of the gyro.
  const Vec3 turn = rotation_log(last.transpose() * imu.attitude);
  R_ = R_ * rotation_exp(turn + bounded(Vec3(period_ * imu.rate - turn), period_ * kWander));
  const Vec3 expected = heading_from_plan(R_ * root_in_imu_, planned) * planned_specific_force(planned);
  const Vec3 felt = R_ * imu.acceleration;
  const Vec3 off = rotation_error(rotation_z(-yaw_error_) * imu.attitude, R_);
  const Vec3 tilted = bounded(Vec3(felt.cross(expected) / expected.squaredNorm()), kTilted);
  Vec3 error = rate_attitude_ * off + rate_gravity_ * tilted;
  error.z() = 0.0;
  R_ = rotation_exp(period_ * error) * R_;
  R_ = rotation_z(yaw_of(imu.attitude * root_in_imu_) - yaw_error_ - yaw_of(R_ * root_in_imu_)) * R_;
  return R_;
}

}  // namespace baton
