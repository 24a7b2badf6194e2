#include "baton/balance/yaw_drift.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace baton {
namespace {

constexpr double kTick = 0.005, kRobotWeight = 54.0;  // [s], [N]

MotionSample at_rest() {
  MotionSample sample;
  sample.dq = VecX::Zero(26);
  return sample;
}

MotionSample walking(double turning = 0.0) {
  MotionSample sample = at_rest();
  sample.dq[10] = 1.0;
  sample.dq[5] = turning;
  return sample;
}

/// Soles seen through an IMU whose yaw drifts.
class Drifting {
 public:
  Drifting(double drift, std::uint64_t seed) : drift_(drift), random_(seed) {}

  /// @param twist yaw of the true soles at a time [rad]
  /// @param left share of the load
  void live(double seconds, const MotionSample& planned, double left = 0.5, double noise = 0.0,
            const std::function<BySide<double>(double)>& twist = nullptr) {
    const int ticks = static_cast<int>(std::lround(seconds / kTick));
    for (int tick = 0; tick < ticks; ++tick) {
      contact_.update({left * kRobotWeight, (1.0 - left) * kRobotWeight});
      yaw += kTick * drift_;
      const BySide<double> soles = twist ? twist(kTick * tick) : BySide<double>{0.0, 0.0};
      const double seen = yaw - estimate.error();
      estimate.update({seen + soles.left + noise * normal_(random_), seen + soles.right + noise * normal_(random_)},
                      contact_, planned);
    }
  }

  YawDrift estimate{kTick};
  double yaw = 0.0;  ///< error of the IMU's [rad]

 private:
  double drift_;
  SoleContact contact_{kRobotWeight, kTick};
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

TEST(YawDrift, ASecondOfPerfectRestTellsIt) {
  for (int k = -50; k <= 50; ++k) {
    Drifting imu(1e-4 * k, 0);  // up to 17 degrees a minute
    imu.live(1.0, at_rest());
    EXPECT_NEAR(imu.estimate.rate(), 1e-4 * k, 0.03 * std::abs(1e-4 * k)) << k;
    EXPECT_NEAR(imu.estimate.error(), imu.yaw, 0.03 * std::abs(imu.yaw) + 1e-12) << k;
  }
}

TEST(YawDrift, EncoderNoiseIsAveragedOverALongRest) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const double drift = 0.006 * (static_cast<double>(seed) / 100.0 - 1.0);
    Drifting imu(drift, seed);
    imu.live(60.0, at_rest(), 0.5, 2e-4);
    EXPECT_NEAR(imu.estimate.rate(), drift, 0.01 * std::abs(drift) + 1e-5) << "seed " << seed;
    EXPECT_NEAR(imu.estimate.error(), imu.yaw, 0.01 * std::abs(imu.yaw) + 1e-3) << "seed " << seed;
  }
}

TEST(YawDrift, AShortNoisyRestTellsLittle) {  // it would be taken for a drift of several degrees a minute
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Drifting imu(0.0, seed);
    imu.live(1.0, at_rest(), 0.5, 1e-3);
    EXPECT_LT(std::abs(imu.estimate.rate()), 3e-4) << "seed " << seed;
  }
}

TEST(YawDrift, ARobotThatSettlesIsNoDrift) {  // by a few tenths of a degree, as play in its joints lets it
  for (int k = -40; k <= 40; ++k) {
    Drifting imu(0.0, 0);
    const auto settling = [k](double t) {
      const double yaw = 1e-4 * k * (1.0 - std::exp(-4.0 * t));
      return BySide<double>{yaw, yaw};
    };
    imu.live(1.0, at_rest(), 0.5, 0.0, settling);
    EXPECT_LE(std::abs(imu.estimate.rate()), 1e-3) << k;
    imu.live(30.0, at_rest(), 0.5, 0.0, [&](double t) { return settling(t + 1.0); });
    EXPECT_LE(std::abs(imu.estimate.rate()), 3e-4) << k;
  }
}

TEST(YawDrift, IsFoundMoreSlowlyByTheSoleThatCarriesAWalkingRobot) {
  Drifting imu(0.003, 0);
  imu.live(1.0, walking(), 1.0);
  EXPECT_GT(imu.estimate.rate(), 0.0);
  EXPECT_LT(imu.estimate.rate(), 0.001);
  imu.live(59.0, walking(), 1.0);
  EXPECT_GT(imu.estimate.rate(), 0.002);
  EXPECT_GT(imu.estimate.error(), 0.7 * imu.yaw);
  EXPECT_LT(imu.estimate.error(), imu.yaw);
}

TEST(YawDrift, AWalkTellsItNoBetterThanItsStepsErr) {  // the same error with each step averages out in no walk
  Drifting imu(0.0, 0);
  imu.live(600.0, walking(), 1.0, 0.0, [](double t) { return BySide<double>{5e-4 * t, 5e-4 * t}; });
  const double walked = imu.estimate.rate();
  EXPECT_GT(walked, 3e-4);
  imu.live(20.0, at_rest(), 0.5, 0.0, [](double) { return BySide<double>{0.3, 0.3}; });
  EXPECT_LT(std::abs(imu.estimate.rate()), 0.1 * walked) << "a rest of seconds knows better than a walk of minutes";
}

TEST(YawDrift, IsNotLearnedInATurnNorFromSolesThatShareTheLoadNorFromOneThatSlips) {
  Drifting turning(0.003, 0), sharing(0.003, 0), slipping(2.0, 0);
  turning.live(10.0, walking(0.3), 1.0);
  EXPECT_EQ(turning.estimate.rate(), 0.0);
  sharing.live(10.0, walking(), 0.5);
  EXPECT_EQ(sharing.estimate.rate(), 0.0);
  slipping.live(0.1, at_rest());
  EXPECT_EQ(slipping.estimate.rate(), 0.0);
}

TEST(YawDrift, WhatARestToldHoldsWhileItWalks) {
  Drifting imu(0.003, 0);
  imu.live(1.0, at_rest());
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, 0.006 * std::sqrt(kTick));
  double twisted = 0.0;
  imu.live(60.0, walking(), 1.0, 0.0, [&](double /*t*/) {
    twisted += normal(random);
    return BySide<double>{twisted, twisted};
  });
  EXPECT_NEAR(imu.estimate.error(), imu.yaw, 0.01);
}

}  // namespace
}  // namespace baton
