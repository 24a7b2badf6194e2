#include "baton/bridge/imu_attitude.hpp"

#include <gmock/gmock.h>

#include "tests/support/random.hpp"

namespace baton::bridge {
namespace {

constexpr double kPeriodOfReadings = 0.02;

/// A sensor that sways and turns, and what it reads.
struct Swaying {
  Vec3 amplitude;
  Vec3 frequency;
  double turning;
  Mat3 attitude(double t) const {
    const Vec3 angle = amplitude.cwiseProduct((frequency * t).array().sin().matrix());
    return rotation_z(turning * t) * rotation_exp(angle);
  }
  Vec3 rate(double t) const {
    constexpr double kStep = 1e-5;
    return rotation_log(attitude(t - kStep).transpose() * attitude(t + kStep)) / (2.0 * kStep);
  }
  Vec3 force(double t) const { return attitude(t).transpose() * Vec3(0, 0, kGravity); }
};

TEST(ImuAttitudeTest, FollowsASensorThatSways) {
  for (int seed = 0; seed < 200; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    const Swaying sensor{random.vector(0.2), Vec3::Constant(3.0) + random.vector(2.0), random(-0.5, 0.5)};
    ImuAttitude attitude(kPeriodOfReadings);
    attitude.start(sensor.force(0.0));
    double yaw = 0.0;
    for (int i = 0; i < 1000; ++i) {
      const double t = i * kPeriodOfReadings;
      attitude.update(sensor.rate(t), sensor.force(t));
      yaw = yaw_of(sensor.attitude(t));
      const Mat3 off = rotation_z(yaw - yaw_of(attitude.attitude())) * attitude.attitude();
      ASSERT_LT(rotation_log(off.transpose() * sensor.attitude(t)).norm(), 0.02) << seed << " at " << t;
    }
  }
}

TEST(ImuAttitudeTest, FindsUpFromRest) {
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Mat3 tilted = rotation_exp(random.horizontal(0.5));
    ImuAttitude attitude(kPeriodOfReadings);
    attitude.start(tilted.transpose() * Vec3(0, 0, 9.5));
    EXPECT_LT((attitude.attitude() * tilted.transpose() * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(yaw_of(attitude.attitude()), 0.0, 1e-9);
  }
}

TEST(ImuAttitudeTest, AWrongBeginIsForgottenButNotWhileAccelerated) {
  ImuAttitude rests(kPeriodOfReadings);
  ImuAttitude falls(kPeriodOfReadings);
  const Mat3 tilted = rotation_exp({0.1, 0.0, 0.0});
  for (ImuAttitude* attitude : {&rests, &falls})
    attitude->start(tilted.transpose() * Vec3::UnitZ());
  for (int i = 0; i < 2000; ++i) {
    rests.update(Vec3::Zero(), {0, 0, kGravity});
    falls.update(Vec3::Zero(), {0, 0, 0.5 * kGravity});
  }
  EXPECT_LT(tilt_of(rests.attitude()), 1e-3);
  EXPECT_NEAR(tilt_of(falls.attitude()), 0.1, 1e-9);
}

}  // namespace
}  // namespace baton::bridge
