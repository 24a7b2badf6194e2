#include "baton/balance/ground_compliance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/random.hpp"

namespace baton {
namespace {

using test::Random;

constexpr double kUpdatePeriod = 0.03;  // [1/ω]

/// Moments that sway, as those on a sole do.
class SwayingMoment {
 public:
  explicit SwayingMoment(Random& random) : size_(random(0.02, 0.06)) {
    for (int k = 0; k < 6; ++k) {
      rate_[k] = random(0.5, 2.5);
      phase_[k] = random(0.0, 2.0 * M_PI);
    }
  }
  [[nodiscard]] Vec2 at(double t) const {
    Vec2 sum = Vec2::Zero();
    for (int k = 0; k < 6; ++k)
      sum[k % 2] += size_ / 3.0 * std::sin(rate_[k] * t + phase_[k]);
    return sum;
  }

 private:
  double size_;
  std::array<double, 6> rate_{};
  std::array<double, 6> phase_{};
};

TEST(GroundCompliance, OfSoftGroundIsFoundWhateverItsSlope) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const double compliance = random(0.4, 2.0);
    const SwayingMoment sway(random);
    const Vec2 slope(random(-0.05, 0.05), random(-0.05, 0.05));
    GroundCompliance ground(kUpdatePeriod);
    for (int k = 0; k * kUpdatePeriod < 120.0; ++k) {
      const Vec2 moment = sway.at(k * kUpdatePeriod);
      const Vec2 noise(random(-2e-3, 2e-3), random(-2e-3, 2e-3));
      // The soles stand by turns, and feel nothing in the air.
      const bool left = k % 200 < 100;
      ground.update(Side::left, slope - compliance * moment + noise, moment, left);
      ground.update(Side::right, left ? Vec2(0.3, 0.3) : Vec2(slope - compliance * moment), moment, !left);
    }
    EXPECT_GT(ground.estimate(), 0.4 * compliance) << seed;
    EXPECT_LT(ground.estimate(), compliance) << seed;
  }
}

TEST(GroundCompliance, IsNotImaginedOnFirmGround) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const SwayingMoment sway(random);
    const double play = random(0.0, 0.002);
    const bool tips = seed % 2 == 0;  // over edges, whatever the moment
    GroundCompliance ground(kUpdatePeriod);
    for (int k = 0; k * kUpdatePeriod < 120.0; ++k) {
      const Vec2 moment = sway.at(k * kUpdatePeriod);
      Vec2 turned = -0.02 * moment;
      for (int axis = 0; axis < 2; ++axis)
        turned[axis] -= std::copysign(play, moment[axis]);
      if (tips) turned += Vec2(random(-0.1, 0.1), random(-0.1, 0.1));
      ground.update(Side::left, turned, moment, true);
      ASSERT_LT(ground.estimate(), 0.05) << seed;
      ASSERT_GE(ground.estimate(), 0.0);
    }
  }
}

TEST(GroundCompliance, IsForgottenOnTheNextFloor) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const SwayingMoment sway(random);
    GroundCompliance ground(kUpdatePeriod);
    const auto live = [&](double from, double to, double compliance) {
      for (double t = from; t < to; t += kUpdatePeriod)
        ground.update(Side::left, -compliance * sway.at(t), sway.at(t), true);
    };
    EXPECT_EQ(ground.estimate(), 0.0);
    live(0.0, 100.0, 1.0);
    const double before = ground.estimate();
    EXPECT_GT(before, 0.5);
    live(100.0, 220.0, 0.0);
    EXPECT_LT(ground.estimate(), 0.2 * before);
  }
}

}  // namespace
}  // namespace baton
