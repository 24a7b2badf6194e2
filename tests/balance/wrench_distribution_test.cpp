#include "baton/balance/wrench_distribution.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <regex>

#include "tests/support/changed_model.hpp"
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
          const Vec2 push = -total.force.z() / (sample.com.z() - sample.zmp_height) * (to - sample.zmp);
          total.force += Vec3(push.x(), push.y(), 0);
          total.moment += sample.com.cross(Vec3(push.x(), push.y(), 0));
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

  BySide<Wrench> share(const MotionSample& sample, const Wrench& total) {
    kinematics_.set(sample.q);
    return distribution_.share(kinematics_, sample.sole, sample.contact, total, sample.force.tail(robot_.nv() - 6));
  }

  /// Largest torque of the standing legs, as a share of the stall torque.
  [[nodiscard]] double load_of_motors(const MotionSample& sample, const BySide<Wrench>& contact) {
    VecX tau;
    kinematics_.set(sample.q);
    joint_torques(kinematics_, sample.force, contact, tau);
    double most = 0.0;
    for (const Side side : kSides) {
      for (const int j : robot_.leg(side))
        most = std::max(most, std::abs(tau[j]) / robot_.joints()[static_cast<std::size_t>(j)].motor.stall);
    }
    return most;
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
  int given_way = 0;
  for (const Case& c : list) {
    const BySide<Pose>& sole = c.sample->sole;
    const BySide<Wrench> plain = share_wrench(robot_, sole, c.sample->contact, c.total);
    const BySide<Wrench> shared = share(*c.sample, c.total);
    for (const Side side : kSides) {
      most_plain = std::max(most_plain, tips(side, sole[side], plain[side]));
      EXPECT_LT(tips(side, sole[side], shared[side]), 1e-3 * unit);
      const Vec3 force = sole[side].R.transpose() * shared[side].force;
      EXPECT_GE(force.z(), -0.002 * weight);
      EXPECT_LE(force.head<2>().norm(), margin_.friction * force.z() + 0.002 * weight);
    }
    EXPECT_LT(load_of_motors(*c.sample, shared), 1.001);
    // What gives way is the moment about the COM and the horizontal force at it.
    const Vec3 force = shared.left.force + shared.right.force;
    const Vec3 moment = shared.left.moment + shared.right.moment;
    EXPECT_NEAR(force.z(), c.total.force.z(), 1e-9 * weight);
    const Vec3& com = c.sample->com;
    const Vec3 changed = Wrench{force, moment}.moment_about(com) - c.total.moment_about(com);
    given_way += (force - c.total.force).norm() + changed.norm() / robot_.profile().stance.com_height > 1e-3 * weight;
  }
  EXPECT_LT(given_way, static_cast<int>(list.size()) / 10);
  EXPECT_GT(most_plain, 5e-3 * unit) << "what the closed form leaves";
}

TEST_P(WrenchDistributionTest, AsPlannedItIsTheClosedFormThatWasVerified) {
  for (const Case& c : cases(false)) {
    const BySide<Wrench> plain = share_wrench(robot_, c.sample->sole, c.sample->contact, c.total);
    const BySide<Wrench> shared = share(*c.sample, c.total);
    for (const Side side : kSides) {
      EXPECT_EQ(shared[side].force, plain[side].force);
      EXPECT_EQ(shared[side].moment, plain[side].moment);
    }
  }
}

TEST(WrenchDistribution, ALongSoleIsTwistedByMoreThanTheDiscThatFitsIntoIt) {
  // G1's soles are four times as long as wide; refused the twist that its plans need, its pelvis turned by 2° with each
  // step.
  const double half_width = 0.012;  // a third of mighty's
  const RobotModel robot =
      test::with_changed_model(test::robot("mighty"), "narrow_soles", [&](const std::string& model) {
        const std::regex sole(R"re((name="\S+_sole_col" class="sole" type="box" pos="[^"]*" size="\S+) \S+ )re");
        return std::regex_replace(model, sole, fmt::format("$1 {} ", half_width));
      });
  const Profile::Margin& margin = robot.profile().margin;
  const Posture home = stand(robot, Pose{}, robot.profile().stance.com_height);
  const MotionSample sample = resting(robot, home);
  Kinematics kinematics(robot);
  kinematics.set(sample.q);
  WrenchDistribution distribution(robot);
  const BySide<bool> alone{true, false};
  const double weight = robot.mass() * kGravity;
  const auto given = [&](double twist, double forward) {  // the ZMP is `forward` of the middle of the left sole
    const Vec3 zmp = sample.sole.left * Vec3(forward, 0, 0);
    const Vec3 force(0, 0, weight);
    const Wrench total{force, zmp.cross(force) + Vec3(0, 0, twist)};
    const BySide<Wrench> shared =
        distribution.share(kinematics, sample.sole, alone, total, sample.force.tail(robot.nv() - 6));
    EXPECT_EQ(shared.right.force, Vec3(Vec3::Zero()));
    return shared.left.moment_about(zmp).z();
  };
  const ConvexPolygon outline = robot.sole(Side::left).inset(0.5 * margin.zmp_feedback);
  double front = 0.0;
  for (const Vec2& corner : outline.vertices())
    front = std::max(front, corner.x());
  const double line = 0.5 * margin.friction * front * weight;
  const double disc = 2.0 / 3.0 * margin.friction * (half_width - 0.5 * margin.zmp_feedback) * weight;
  ASSERT_GT(line, 2.0 * disc);
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_NEAR(given(sign * 0.98 * line, 0.0), sign * 0.98 * line, 1e-9 * line);
    EXPECT_LT(sign * given(sign * 1.5 * line, 0.0), 1.05 * line) << "beyond that it would slip";
    // The nearer the ends, the less: at the very end, no more than the disc.
    const double near_end = 0.9 * front;
    const double there = disc + 0.1 * (line - disc);
    EXPECT_NEAR(given(sign * 0.95 * there, near_end), sign * 0.95 * there, 1e-9 * line);
    EXPECT_LT(sign * given(sign * line, near_end), 1.2 * there);
  }
}

TEST_P(WrenchDistributionTest, ASmallChangeOfTheZmpIsASmallChangeOfTheShares) {
  const double weight = robot_.mass() * kGravity;
  const double step = 1e-4;  // [m]
  for (const Case& c : cases(true)) {
    Wrench moved = c.total;
    moved.moment += Vec3(step, step, 0).cross(Vec3(0, 0, c.total.force.z()));
    const BySide<Wrench> before = share(*c.sample, c.total);
    const BySide<Wrench> after = share(*c.sample, moved);
    EXPECT_LT((after.left.force - before.left.force).norm(), 0.05 * weight);
  }
}

TEST_P(WrenchDistributionTest, WhereMotorsAreTooWeakTheMomentGivesWayBeforeTheForce) {
  const double weight = robot_.mass() * kGravity;
  const double height = robot_.profile().stance.com_height;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  int limited = 0;
  for (const Case& c : cases(false)) {
    // A moment about the COM that no leg can give, and a force that each can.
    Wrench total = c.total;
    const Vec3 force = 0.02 * weight * Vec3(anywhere(random), anywhere(random), 0);
    total.force += force;
    total.moment += c.sample->com.cross(force) + 0.6 * weight * height * Vec3(anywhere(random), anywhere(random), 0);
    const BySide<Wrench> shared = share(*c.sample, total);
    const Wrench sum{shared.left.force + shared.right.force, shared.left.moment + shared.right.moment};
    const Vec3& com = c.sample->com;
    const double moment = (sum.moment_about(com) - total.moment_about(com)).norm() / height;
    const double lost = (sum.force - total.force).norm();
    EXPECT_LT(load_of_motors(*c.sample, shared), 1.01);
    if (moment < 0.05 * weight) continue;
    ++limited;
    EXPECT_LT(lost, 0.5 * moment);
  }
  EXPECT_GT(limited, 100);
}

}  // namespace
}  // namespace baton
