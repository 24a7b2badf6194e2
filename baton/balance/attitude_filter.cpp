#include "baton/balance/attitude_filter.hpp"

#include <utility>

#include "baton/balance/specific_force.hpp"

namespace baton {
namespace {

constexpr double kAttitudeRate = 0.03;  ///< at which roll and pitch follow the sensor's attitude [ω]
constexpr double kGravityRate = 0.1;    ///< at which roll and pitch follow the direction of gravity [ω]
constexpr double kMostOff = 0.2;        ///< deviation from the sensor's attitude at which the filter restarts [rad]

}  // namespace

AttitudeFilter::AttitudeFilter(const Pose& imu_in_root, double period, double omega)
    : root_in_imu_(imu_in_root.R.transpose()),
      period_(period),
      rate_attitude_(kAttitudeRate * omega),
      rate_gravity_(kGravityRate * omega) {}

const Mat3& AttitudeFilter::update(const Measurement::Imu& imu, const MotionSample& planned) {
  if (std::exchange(first_, false)) return R_ = imu.attitude;
  R_ = R_ * rotation_exp(period_ * imu.rate);
  const Vec3 expected = heading_from_plan(R_ * root_in_imu_, planned) * planned_specific_force(planned);
  const Vec3 felt = R_ * imu.acceleration;
  const Vec3 off = rotation_error(rotation_z(-drifted_) * imu.attitude, R_);
  if (off.norm() > kMostOff) return R_ = rotation_z(-drifted_) * imu.attitude;
  Vec3 error = rate_attitude_ * off + rate_gravity_ * felt.cross(expected) / expected.squaredNorm();
  error.z() = 0.0;
  R_ = rotation_exp(period_ * error) * R_;
  drifted_ += period_ * yaw_drift_;
  R_ = rotation_z(yaw_of(imu.attitude * root_in_imu_) - drifted_ - yaw_of(R_ * root_in_imu_)) * R_;
  return R_;
}

}  // namespace baton
