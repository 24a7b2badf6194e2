/// Rotations and poses.
#pragma once

#include <Eigen/Dense>

namespace baton {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using VecX = Eigen::VectorXd;
using Mat3 = Eigen::Matrix3d;
using MatX = Eigen::MatrixXd;

/// Standard gravity [m/s²].
inline constexpr double kGravity = 9.80665;

/// Position and attitude of a frame in its parent: x_parent = p + R x_frame.
struct Pose {
  Vec3 p = Vec3::Zero();      ///< [m]
  Mat3 R = Mat3::Identity();  ///< rotation, columns are the frame's axes

  [[nodiscard]] Pose operator*(const Pose& other) const { return {p + R * other.p, R * other.R}; }
  [[nodiscard]] Vec3 operator*(const Vec3& x) const { return p + R * x; }
  [[nodiscard]] Pose inverse() const { return {-(R.transpose() * p), R.transpose()}; }
};

/// Distance between a * point and b * point [m]. Measured at the point that matters, as a small rotation about a far
/// origin moves it a lot.
[[nodiscard]] inline double distance_at(const Pose& a, const Pose& b, const Vec3& point) {
  return (a * point - b * point).norm();
}

/// v, shortened to the length `most` if it is longer.
template <typename Vector>
[[nodiscard]] Vector bounded(const Vector& v, double most) {
  const double size = v.norm();
  return size > most ? Vector(v * (most / size)) : v;
}

/// The part of v beyond a dead band.
template <typename Vector>
[[nodiscard]] Vector beyond(const Vector& v, double band) {
  const double size = v.norm();
  return size > band ? Vector(v * (1.0 - band / size)) : Vector(Vector::Zero());
}
[[nodiscard]] inline double beyond(double v, double band) {
  return v > band ? v - band : v < -band ? v + band : 0.0;
}

/// Rotation vector [rad] → rotation matrix.
[[nodiscard]] Mat3 rotation_exp(const Vec3& theta);

/// Rotation matrix → rotation vector [rad], norm in 0…π.
[[nodiscard]] Vec3 rotation_log(const Mat3& R);

/// Rotation vector that turns `R` into `goal`, in the parent frame: log(goal Rᵀ) [rad].
[[nodiscard]] Vec3 rotation_error(const Mat3& goal, const Mat3& R);

/// Rotation about z.
[[nodiscard]] Mat3 rotation_z(double yaw);

/// Heading of the frame's x axis about z [rad], −π…π.
[[nodiscard]] double yaw_of(const Mat3& R);

/// Angle of the frame's z axis from the vertical [rad].
[[nodiscard]] double tilt_of(const Mat3& R);

/// Roll, pitch, yaw [rad] with R = Rz(yaw) Ry(pitch) Rx(roll).
[[nodiscard]] Vec3 rpy_of(const Mat3& R);

/// Inverse of `rpy_of`.
[[nodiscard]] Mat3 rotation_rpy(const Vec3& rpy);

/// The angle wrapped to −π…π [rad].
[[nodiscard]] double wrap_angle(double angle);

/// Mean of two headings, along the shorter arc [rad].
[[nodiscard]] double mean_yaw(double a, double b);

/// Point on the geodesic from `a` (s = 0) to `b` (s = 1).
[[nodiscard]] Mat3 interpolate(const Mat3& a, const Mat3& b, double s);

/// Cross-product matrix: skew(a) b = a × b.
[[nodiscard]] Mat3 skew(const Vec3& a);

}  // namespace baton
