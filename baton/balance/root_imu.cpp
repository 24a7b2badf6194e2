#include "baton/balance/root_imu.hpp"

#include <utility>

namespace baton {

RootImu::RootImu(const Pose& sensor, double yaw, double period) : sensor_(sensor), start_yaw_(yaw), period_(period) {}

RootImu::RootMotion RootImu::update(const Measurement::Imu& imu) {
  const bool first = std::exchange(first_, false);
  if (first) yaw_offset_ = rotation_z(start_yaw_ - yaw_of(imu.attitude * sensor_.R.transpose()));
  RootMotion root;
  root.R = yaw_offset_ * imu.attitude * sensor_.R.transpose();
  root.rate = sensor_.R * imu.rate;

  const Vec3 rate = root.R * root.rate;
  if (!first) root.angular_accel = (rate - previous_rate_) / period_;
  previous_rate_ = rate;
  const Vec3 lever = root.R * sensor_.p;
  root.acceleration = root.R * sensor_.R * imu.acceleration - Vec3(0, 0, kGravity) - root.angular_accel.cross(lever) -
                      rate.cross(rate.cross(lever));
  return root;
}

}  // namespace baton
