#include "baton/math/pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace baton {
namespace {

constexpr double kPi = std::numbers::pi;

class PoseTest : public testing::Test {
 protected:
  double real(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  Vec3 axis() {
    std::normal_distribution<double> normal;
    return Vec3(normal(random_), normal(random_), normal(random_)).normalized();
  }
  Mat3 rotation() { return rotation_exp(real(0, kPi) * axis()); }
  std::mt19937_64 random_{31};
};

TEST_F(PoseTest, LogUndoesExpFromTheSmallestAngleToHalfATurn) {
  for (int trial = 0; trial < 3000; ++trial) {
    for (const double angle : {real(0.0, kPi), std::pow(10.0, real(-14, 0)), kPi - std::pow(10.0, real(-14, 0)), 0.0}) {
      const Vec3 theta = angle * axis();
      const Mat3 R = rotation_exp(theta);
      ASSERT_LT((R * R.transpose() - Mat3::Identity()).norm(), 1e-12);
      ASSERT_NEAR(R.determinant(), 1.0, 1e-12);
      const Vec3 back = rotation_log(R);
      ASSERT_LE(back.norm(), kPi + 1e-12);
      // Within rounding of half a turn the axis may come back reversed.
      const double error = std::min((back - theta).norm(), angle > kPi - 1e-7 ? (back + theta).norm() : 1e9);
      ASSERT_LT(error, 1e-8) << "angle π − " << kPi - angle;
      ASSERT_LT((rotation_exp(back) - R).norm(), 1e-8);
    }
  }
  for (const Vec3& half_turn : {Vec3(kPi, 0, 0), Vec3(0, kPi, 0), Vec3(0, 0, kPi)}) {
    EXPECT_LT((rotation_exp(rotation_log(rotation_exp(half_turn))) - rotation_exp(half_turn)).norm(), 1e-9);
  }
}

TEST_F(PoseTest, SmallErrorsAreResolvedFinely) {
  for (int trial = 0; trial < 1000; ++trial) {
    const Mat3 R = rotation();
    const Vec3 theta = std::pow(10.0, real(-9, -3)) * axis();
    ASSERT_LT((rotation_error(rotation_exp(theta) * R, R) - theta).norm(), 1e-14);
  }
}

TEST_F(PoseTest, RollPitchYawRoundTrip) {
  for (int trial = 0; trial < 3000; ++trial) {
    const Vec3 rpy(real(-kPi, kPi), real(-1.5, 1.5), real(-kPi, kPi));
    ASSERT_LT((rpy_of(rotation_rpy(rpy)) - rpy).norm(), 1e-9);
    ASSERT_NEAR(yaw_of(rotation_rpy(rpy)), rpy.z(), 1e-9);
  }
  EXPECT_LT((rotation_rpy({0, 0, 0.7}) - rotation_z(0.7)).norm(), 1e-15);
}

TEST_F(PoseTest, MeanYawIsMidwayOnTheShorterArc) {
  for (int trial = 0; trial < 3000; ++trial) {
    const double a = real(-10, 10);
    const double half = real(-0.49, 0.49) * kPi;
    const double mean = mean_yaw(a, a + 2 * half + 2 * kPi * std::floor(real(-2, 3)));
    ASSERT_NEAR(wrap_angle(mean - (a + half)), 0.0, 1e-9);
    ASSERT_LE(std::abs(mean), kPi + 1e-12);
    ASSERT_NEAR(wrap_angle(mean - mean_yaw(a + 2 * half, a)), 0.0, 1e-9);
  }
  EXPECT_NEAR(std::abs(mean_yaw(3.1, -3.1)), kPi, 1e-9);
}

TEST_F(PoseTest, InterpolationGoesTheShortWayAtAnEvenPace) {
  for (int trial = 0; trial < 1000; ++trial) {
    const Mat3 a = rotation();
    const Vec3 theta = real(0, 3.1) * axis();
    const Mat3 b = rotation_exp(theta) * a;
    const double s = real(0, 1);
    ASSERT_LT((interpolate(a, b, s) - rotation_exp(s * theta) * a).norm(), 1e-8);
    ASSERT_LT((interpolate(a, b, 0) - a).norm(), 1e-12);
    ASSERT_LT((interpolate(a, b, 1) - b).norm(), 1e-8);
  }
}

TEST_F(PoseTest, PosesComposeAndInvert) {
  for (int trial = 0; trial < 1000; ++trial) {
    const Pose a{3 * axis(), rotation()};
    const Pose b{2 * axis(), rotation()};
    const Vec3 x = axis();
    ASSERT_LT(((a * b) * x - a * (b * x)).norm(), 1e-12);
    ASSERT_LT((a.inverse() * (a * x) - x).norm(), 1e-12);
    ASSERT_LT((skew(a.p) * x - a.p.cross(x)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace baton
