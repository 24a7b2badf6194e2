#include "baton/balance/wrench_distribution.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

class WrenchDistributionTest : public testing::TestWithParam<std::string> {
 protected:
  struct Case {
    const MotionSample* sample;
    Wrench total;
  };

  /// Both soles stand; the ZMP is where it was planned, or anywhere that the stabiliser may command it.
  [[nodiscard]] std::vector<Case> cases(bool commanded) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> anywhere(-0.4, 0.4);
    const double height = robot_.profile().stance.com_height;
    std::vector<Case> list;
    for (const VerifiedMotion& verified : test::sample_motions(GetParam())) {
      const Motion& motion = *verified;
      for (const MotionSample& sample : motion.samples) {
        if (!sample.contact.left || !sample.contact.right || !sample.zmp_region) continue;
        kinematics_.set(sample.q);
        Wrench total = ground_wrench(kinematics_, sample.force);
        if (commanded) {
          const Vec2 to = sample.zmp_region->nearest(sample.zmp + height * Vec2(anywhere(random), anywhere(random)));
          const Vec2 shift = to - sample.zmp;
          total.moment += Vec3(shift.x(), shift.y(), 0).cross(Vec3(0, 0, total.force.z()));
        }
        list.push_back({&sample, total});
      }
    }
    return list;
  }

  /// The moment by which a sole would have to give more than it can, as its centre of pressure is outside it [N·m].
  [[nodiscard]] double tips(Side side, const Pose& sole, const Wrench& wrench) const {
    const Vec3 force = sole.R.transpose() * wrench.force;
    const Vec3 moment = sole.R.transpose() * wrench.moment_about(sole.p);
    const double inside = robot_.sole(side).margin(Vec2(-moment.y(), moment.x()) / force.z());
    return force.z() > 0.0 ? std::max(0.0, -inside * force.z()) : moment.head<2>().norm();
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const Profile::Margin& margin_ = robot_.profile().margin;
  Kinematics kinematics_{robot_};
  WrenchDistribution distribution_{robot_};
};

INSTANTIATE_TEST_SUITE_P(Robots, WrenchDistributionTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(WrenchDistributionTest, WhateverZmpIsCommandedEachSoleCanGiveItsShare) {
  const std::vector<Case> list = cases(true);
  ASSERT_GT(list.size(), 1000u);
  const double weight = robot_.mass() * kGravity;
  const double unit = weight * robot_.profile().stance.com_height;
  double most_plain = 0.0;
  for (const Case& c : list) {
    const BySide<Pose>& sole = c.sample->sole;
    const BySide<Wrench> plain = share_wrench(robot_, sole, c.sample->contact, c.total);
    const BySide<Wrench> shared = distribution_.share(sole, c.sample->contact, c.total);
    for (const Side side : kSides) {
      most_plain = std::max(most_plain, tips(side, sole[side], plain[side]));
      EXPECT_LT(tips(side, sole[side], shared[side]), 1e-3 * unit);
      const Vec3 force = sole[side].R.transpose() * shared[side].force;
      EXPECT_GE(force.z(), -0.002 * weight);
      EXPECT_LE(force.head<2>().norm(), margin_.friction * force.z() + 0.002 * weight);
    }
    EXPECT_LT((shared.left.force + shared.right.force - c.total.force).norm(), 1e-9 * weight);
    EXPECT_LT((shared.left.moment + shared.right.moment - c.total.moment).norm(), 1e-9 * weight);
  }
  EXPECT_GT(most_plain, 5e-3 * unit) << "what the closed form leaves";
}

TEST_P(WrenchDistributionTest, AsPlannedItIsTheClosedFormThatWasVerified) {
  for (const Case& c : cases(false)) {
    const BySide<Wrench> plain = share_wrench(robot_, c.sample->sole, c.sample->contact, c.total);
    const BySide<Wrench> shared = distribution_.share(c.sample->sole, c.sample->contact, c.total);
    for (const Side side : kSides) {
      EXPECT_EQ(shared[side].force, plain[side].force);
      EXPECT_EQ(shared[side].moment, plain[side].moment);
    }
  }
}

TEST_P(WrenchDistributionTest, ASmallChangeOfTheZmpIsASmallChangeOfTheShares) {
  const double weight = robot_.mass() * kGravity;
  const double step = 1e-4;  // [m]
  for (const Case& c : cases(true)) {
    Wrench moved = c.total;
    moved.moment += Vec3(step, step, 0).cross(Vec3(0, 0, c.total.force.z()));
    const BySide<Wrench> before = distribution_.share(c.sample->sole, c.sample->contact, c.total);
    const BySide<Wrench> after = distribution_.share(c.sample->sole, c.sample->contact, moved);
    EXPECT_LT((after.left.force - before.left.force).norm(), 0.05 * weight);
  }
}

}  // namespace
}  // namespace baton
