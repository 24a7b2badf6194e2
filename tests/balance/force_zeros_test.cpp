#include "baton/balance/force_zeros.hpp"

#include <gtest/gtest.h>

#include <random>

namespace baton {
namespace {

constexpr double kWeight = 54.0;
constexpr double kHeight = 0.26;
constexpr double kScaledPeriod = 0.005 * 6.14;  // [1/ω]

MotionSample standing_on(bool left, bool right) {
  MotionSample sample;
  sample.contact = {left, right};
  return sample;
}

/// The soles that stand share the weight.
BySide<Wrench> forces(const MotionSample& planned) {
  BySide<Wrench> sole;
  const double load = planned.contact.left && planned.contact.right ? 0.5 * kWeight : kWeight;
  for (const Side side : kSides) {
    if (planned.contact[side]) sole[side] = {Vec3(1.0, -0.5, load), Vec3(0.1, 0.2, 0.0)};
  }
  return sole;
}

TEST(ForceZeros, AreFoundInTheAir) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    BySide<Vec3> zero;
    for (const Side side : kSides) {
      const double aside = unit(random);
      zero[side] = Vec3(2.0 * aside, 2.0 * unit(random), 20.0 * unit(random));
    }
    ForceZeros zeros(kWeight, kHeight, kScaledPeriod);
    BySide<Wrench> corrected;
    for (int tick = 0; tick < 400; ++tick) {  // steps of 0.25 s in the air, a foot after the other
      const int phase = tick / 50 % 4;
      const MotionSample planned = standing_on(phase != 1, phase != 3);
      corrected = forces(planned);
      for (const Side side : kSides)
        corrected[side].force += zero[side];
      zeros.correct(corrected, planned);
    }
    const BySide<Wrench> truth = forces(standing_on(true, false));
    EXPECT_TRUE(zeros.known().left && zeros.known().right);
    EXPECT_LT((corrected.left.force - truth.left.force).norm(), 1.5) << "seed " << seed;
  }
}

TEST(ForceZeros, AreNotLearnedStanding) {
  ForceZeros zeros(kWeight, kHeight, kScaledPeriod);
  const MotionSample planned = standing_on(true, true);
  for (int tick = 0; tick < 1000; ++tick) {
    BySide<Wrench> sole = forces(planned);
    zeros.correct(sole, planned);
    ASSERT_EQ(sole, forces(planned));
  }
  EXPECT_FALSE(zeros.known().left || zeros.known().right);
}

TEST(ForceZeros, AreNotLearnedFromAFootThatStandsUnplanned) {
  // As after a fall, when the robot was stood up on both feet and the last plan stood on one.
  ForceZeros zeros(kWeight, kHeight, kScaledPeriod);
  for (int tick = 0; tick < 4000; ++tick) {
    BySide<Wrench> sole = forces(standing_on(true, true));
    zeros.correct(sole, standing_on(true, false));
    ASSERT_EQ(sole, forces(standing_on(true, true))) << tick;
  }
}

TEST(ForceZeros, AFootThatLandsTooEarlyTellsLittle) {
  ForceZeros zeros(kWeight, kHeight, kScaledPeriod);
  BySide<Wrench> sole;
  for (int tick = 0; tick < 100; ++tick) {  // in the air, without errors
    sole = forces(standing_on(true, false));
    zeros.correct(sole, standing_on(true, false));
  }
  for (int tick = 0; tick < 10; ++tick) {  // touched 50 ms early
    sole = forces(standing_on(true, true));
    zeros.correct(sole, standing_on(true, false));
  }
  EXPECT_LT((sole.right.force - forces(standing_on(true, true)).right.force).norm(), 0.01 * kWeight);
}

}  // namespace
}  // namespace baton
