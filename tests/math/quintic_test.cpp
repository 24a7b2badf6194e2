#include "baton/math/quintic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

namespace baton {
namespace {

TEST(Quintic, MeetsItsEndsAndIsItsOwnDerivative) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> value(-2.0, 2.0);
  std::uniform_real_distribution<double> duration(0.2, 3.0);
  for (int trial = 0; trial < 3000; ++trial) {
    const Jet a{value(random), value(random), value(random)};
    const Jet b{value(random), value(random), value(random)};
    const double T = duration(random);
    const Quintic quintic(a, b, T);
    for (const auto& [t, jet] : {std::pair{0.0, a}, std::pair{T, b}, std::pair{-1.0, a}, std::pair{T + 1.0, b}}) {
      const Jet at = quintic.at(t);
      ASSERT_NEAR(at.x, jet.x, 1e-9);
      ASSERT_NEAR(at.dx, jet.dx, 1e-8);
      ASSERT_NEAR(at.ddx, jet.ddx, 1e-7);
    }
    const double h = 1e-4 * T;
    const double t = T * std::uniform_real_distribution<double>(0.01, 0.99)(random);
    const Jet before = quintic.at(t - h);
    const Jet now = quintic.at(t);
    const Jet after = quintic.at(t + h);
    const double scale = 1.0 + std::abs(now.ddx) + 1000.0 / (T * T * T);
    ASSERT_NEAR((after.x - before.x) / (2 * h), now.dx, 1e-6 * scale);
    ASSERT_NEAR((after.dx - before.dx) / (2 * h), now.ddx, 1e-5 * scale / T);
  }
}

TEST(SmoothStep, IsTheQuinticFromRestToRest) {
  for (const double T : {0.3, 1.0, 2.5}) {
    const Quintic quintic({0, 0, 0}, {1, 0, 0}, T);
    double last = 0.0;
    for (int k = 0; k <= 1000; ++k) {
      const double t = T * k / 1000.0;
      const Jet a = smooth_step(t, T);
      const Jet b = quintic.at(t);
      ASSERT_NEAR(a.x, b.x, 1e-12);
      ASSERT_NEAR(a.dx, b.dx, 1e-10);
      ASSERT_NEAR(a.ddx, b.ddx, 1e-9);
      ASSERT_GE(a.x, last);
      last = a.x;
    }
    EXPECT_EQ(smooth_step(-1.0, T).x, 0.0);
    EXPECT_EQ(smooth_step(-1.0, T).dx, 0.0);
    EXPECT_EQ(smooth_step(T + 1.0, T).x, 1.0);
    EXPECT_EQ(smooth_step(T + 1.0, T).ddx, 0.0);
  }
  EXPECT_EQ(smooth_step(0.0, 0.0).x, 1.0);
}

}  // namespace
}  // namespace baton
