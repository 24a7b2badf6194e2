#include "baton/balance/yaw_drift.hpp"

#include <gtest/gtest.h>

#include <random>

namespace baton {
namespace {

constexpr double kPeriod = 0.005;
constexpr double kWeight = 54.0;

MotionSample at_rest() {
  MotionSample sample;
  sample.dq = VecX::Zero(26);
  return sample;
}

/// Estimated drift after `seconds`, of soles that turn by the true drift less the estimate.
double estimate(double drift, double seconds, MotionSample planned, double noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  YawDrift yaw_drift(kPeriod);
  SoleContact contact(kWeight, kPeriod);
  double yaw = 0.0;
  const int ticks = static_cast<int>(std::lround(seconds / kPeriod));
  for (int tick = 0; tick < ticks; ++tick) {
    contact.update({0.5 * kWeight, 0.5 * kWeight});
    yaw += kPeriod * (drift - yaw_drift.rate());
    yaw_drift.update({yaw + noise * normal(random), yaw + noise * normal(random)}, contact, planned);
  }
  return yaw_drift.rate();
}

TEST(YawDrift, IsFoundAtRest) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const double drift = 0.006 * (static_cast<double>(seed) / 100.0 - 1.0);
    EXPECT_NEAR(estimate(drift, 60.0, at_rest(), 2e-4, seed), drift, 0.1 * std::abs(drift) + 1e-4) << "seed " << seed;
  }
}

TEST(YawDrift, AShortRestTellsLittle) {  // its noise would be taken for a drift of several degrees a minute
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    EXPECT_LT(std::abs(estimate(0.0, 1.0, at_rest(), 1e-3, seed)), 6e-4) << "seed " << seed;
}

TEST(YawDrift, IsFoundMoreSlowlyWhileSolesMayTwist) {
  MotionSample walking = at_rest();
  walking.dq[10] = 1.0;
  const double after_a_second = estimate(0.003, 1.0, walking, 0.0, 1);
  EXPECT_GT(after_a_second, 0.0);
  EXPECT_LT(after_a_second, 0.001);
  EXPECT_GT(estimate(0.003, 60.0, walking, 0.0, 1), 0.0014);
}

TEST(YawDrift, IsNotLearnedInATurnNorFromASoleThatSlips) {
  MotionSample turning = at_rest();
  turning.dq[5] = 0.3;
  EXPECT_EQ(estimate(0.003, 10.0, turning, 0.0, 1), 0.0);
  EXPECT_EQ(estimate(2.0, 0.1, at_rest(), 0.0, 1), 0.0);
}

}  // namespace
}  // namespace baton
