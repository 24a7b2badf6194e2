#include "baton/balance/joint_play.hpp"

#include <gtest/gtest.h>

#include "baton/ik/stand.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;

constexpr BySide<bool> kBothStand{true, true};

/// A standing robot whose motors have play: the links keep still, and torques push motors to and fro.
class JointPlayTest : public testing::TestWithParam<std::string> {
 protected:
  /// Load passes between the legs, then the right foot leaves the ground for a moment.
  /// @param noise of the encoders [rad]
  void step(JointPlay& joint_play, double play, Random& random, double noise = 0.0) {
    VecX torque = VecX::Zero(n_);
    const auto push = [&] {
      for (Eigen::Index j = 0; j < n_; ++j)
        torque[j] = std::copysign(random(0.02, 0.5), random(-1.0, 1.0)) *
                    robot_.joints()[static_cast<std::size_t>(j)].motor.stall;
    };
    const auto pass = [&](int ticks, const BySide<bool>& planned, double left) {
      contact_.update({left * weight_, (1.0 - left) * weight_});
      for (int tick = 0; tick < ticks; ++tick) {
        for (Eigen::Index j = 0; j < n_; ++j) {
          const double loaded = 0.001 * robot_.joints()[static_cast<std::size_t>(j)].motor.stall;
          if (std::abs(torque[j]) > loaded) motor_[j] = link_[j] + std::copysign(play, torque[j]);
        }
        read_ = motor_;
        for (double& angle : read_)
          angle += random(-noise, noise);
        found_ = read_;
        joint_play.correct(found_, torque, contact_, planned);
      }
    };
    push();
    pass(30, {true, false}, 1.0);
    pass(10, kBothStand, 0.7);
    push();
    pass(30, kBothStand, 0.3);
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const double weight_ = robot_.mass() * kGravity;
  const Eigen::Index n_ = robot_.nv() - 6;
  const VecX link_ =
      stand(robot_, World::load("flat").site("start"), robot_.profile().stance.com_height).q.tail(robot_.nv() - 6);
  VecX motor_ = link_;
  VecX read_;  ///< by the encoders
  VecX found_;
  SoleContact contact_{weight_, robot_.profile().tick.period};
};

INSTANTIATE_TEST_SUITE_P(Robots, JointPlayTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(JointPlayTest, IsFoundWhateverItsSize) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    const double play = random(1e-3, 0.012);
    motor_ = link_;
    JointPlay joint_play(robot_);
    for (int steps = 0; steps < 40; ++steps)
      step(joint_play, play, random);
    EXPECT_NEAR(joint_play.estimate(), play, 0.1 * play) << seed;
    EXPECT_LT((found_ - link_).norm(), 0.2 * (motor_ - link_).norm()) << seed;
  }
}

TEST_P(JointPlayTest, IsNotImagined) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    motor_ = link_;
    JointPlay joint_play(robot_);
    for (int steps = 0; steps < 40; ++steps) {
      step(joint_play, 0.0, random, 2e-4);
      EXPECT_EQ(joint_play.estimate(), 0.0) << seed << " after " << steps;
      EXPECT_EQ(found_, read_);
    }
  }
}

TEST_P(JointPlayTest, WithoutTorquesNothingIsCorrected) {
  Random random(1);
  JointPlay joint_play(robot_);
  for (int steps = 0; steps < 40; ++steps)
    step(joint_play, 0.01, random);
  ASSERT_GT(joint_play.estimate(), 0.005);
  VecX q = link_;
  joint_play.correct(q, VecX(), contact_, kBothStand);
  EXPECT_EQ(q, link_);
}

TEST_P(JointPlayTest, StaysWithinItsBoundWhateverIsMeasured) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    JointPlay joint_play(robot_);
    for (int tick = 0; tick < 400; ++tick) {
      VecX q(n_), torque(n_);
      for (Eigen::Index j = 0; j < n_; ++j) {
        q[j] = random(-3.0, 3.0);
        torque[j] = random(-100.0, 100.0);
      }
      contact_.update({random(-1.0, 2.0) * weight_, random(-1.0, 2.0) * weight_});
      const VecX read = q;
      joint_play.correct(q, torque, contact_, {random(-1.0, 4.0) > 0.0, random(-1.0, 4.0) > 0.0});
      ASSERT_GE(joint_play.estimate(), 0.0);
      ASSERT_LE(joint_play.estimate(), 0.02);
      ASSERT_LE((q - read).lpNorm<Eigen::Infinity>(), 0.0201);
    }
  }
}

}  // namespace
}  // namespace baton
