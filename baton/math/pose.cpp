#include "baton/math/pose.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace baton {

Mat3 rotation_exp(const Vec3& theta) {
  const double angle = theta.norm();
  if (angle < 1e-12) return Mat3::Identity() + skew(theta);
  return Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix();
}

Vec3 rotation_log(const Mat3& R) {
  const Vec3 axis2(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sine2 = axis2.norm();
  const double angle = std::atan2(sine2, R.trace() - 1.0);
  if (sine2 > 1e-6) return axis2 * (angle / sine2);
  if (angle < 1.0) return 0.5 * axis2;
  const Eigen::AngleAxisd near_pi(R);  // where the skew-symmetric part vanishes
  return near_pi.angle() * near_pi.axis();
}

Vec3 rotation_error(const Mat3& goal, const Mat3& R) {
  return rotation_log(goal * R.transpose());
}

Mat3 rotation_z(double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  Mat3 R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

double yaw_of(const Mat3& R) {
  return std::atan2(R(1, 0), R(0, 0));
}

double tilt_of(const Mat3& R) {
  return std::acos(std::clamp(R(2, 2), -1.0, 1.0));
}

Vec3 rpy_of(const Mat3& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))), yaw_of(R)};
}

Mat3 rotation_rpy(const Vec3& rpy) {
  return rotation_z(rpy.z()) * rotation_exp({0, rpy.y(), 0}) * rotation_exp({rpy.x(), 0, 0});
}

double wrap_angle(double angle) {
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

double mean_yaw(double a, double b) {
  return wrap_angle(a + 0.5 * wrap_angle(b - a));
}

Mat3 interpolate(const Mat3& a, const Mat3& b, double s) {
  return rotation_exp(s * rotation_error(b, a)) * a;
}

Mat3 skew(const Vec3& a) {
  Mat3 S;
  S << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return S;
}

}  // namespace baton
