#include "baton/bridge/imu_attitude.hpp"

#include <cmath>

#include "baton/model/contact.hpp"

namespace baton::bridge {
namespace {

constexpr double kGravityRate = 0.2;  ///< at which roll and pitch follow the direction of gravity [1/s]
constexpr double kAtRest = 0.1;       ///< share of gravity by which a specific force may differ from it

}  // namespace

void ImuAttitude::start(const Vec3& force) {
  R_ = Eigen::Quaterniond::FromTwoVectors(force, Vec3::UnitZ()).toRotationMatrix();
  R_ = rotation_z(-yaw_of(R_)) * R_;
  last_rate_.setZero();
}

void ImuAttitude::update(const Vec3& rate, const Vec3& force) {
  R_ = R_ * rotation_exp(0.5 * period_ * (last_rate_ + rate));
  last_rate_ = rate;
  if (std::abs(force.norm() - kGravity) > kAtRest * kGravity) return;  // accelerated: it tells little
  R_ = rotation_exp(period_ * kGravityRate * (R_ * force).normalized().cross(Vec3::UnitZ())) * R_;
}

}  // namespace baton::bridge
