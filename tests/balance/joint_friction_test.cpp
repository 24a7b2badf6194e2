#include "baton/balance/joint_friction.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;

class JointFrictionTest : public testing::TestWithParam<std::string> {
 protected:
  /// Servos that hold joints, with friction, on their way: what is not compensated shows as an error.
  /// @param noise of the encoders [rad]
  /// @return mean estimate of the last half
  double move(JointFriction& friction, double share, int ticks, Random& random, double noise) {
    double sum = 0.0;
    for (int tick = 0; tick < ticks; ++tick) {
      for (Eigen::Index j = 0; j < n_; ++j) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
        phase_[j] += robot_.omega() * robot_.profile().tick.period * random(0.5, 1.5);
        speed_[j] = 0.3 * robot_.omega() * std::sin(phase_[j]);
        const double against = std::copysign(share * joint.motor.stall, speed_[j]);
        error_[j] = (against - friction.torque(static_cast<int>(j), speed_[j])) / joint.gains.kp + offset_[j] +
                    noise * random(-1.0, 1.0);
      }
      friction.update(speed_, error_);
      if (tick >= ticks / 2) sum += friction.share();
    }
    return sum / (ticks - ticks / 2);
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
  VecX phase_ = VecX::LinSpaced(n_, 0.0, 6.0);
  VecX speed_ = VecX::Zero(n_);
  VecX error_ = VecX::Zero(n_);
  VecX offset_ = VecX::Zero(n_);
};

INSTANTIATE_TEST_SUITE_P(Robots, JointFrictionTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(JointFrictionTest, IsFoundBesideZeroErrorsAndNoise) {
  const int ticks = static_cast<int>(20.0 / (robot_.omega() * robot_.profile().tick.period));
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const double share = random(0.0, 0.08);
    for (double& angle : offset_)
      angle = random(-2e-3, 2e-3);
    JointFriction friction(robot_);
    // With that noise the estimate sways, and it is never negative.
    EXPECT_NEAR(move(friction, share, ticks, random, 1e-3), share, 0.006) << seed;
    // When the joints become lighter, so does the estimate.
    EXPECT_NEAR(move(friction, 0.5 * share, ticks, random, 1e-3), 0.5 * share, 0.006) << seed;
    EXPECT_NEAR(friction.share(), 0.5 * share, 0.02) << seed;
  }
}

TEST_P(JointFrictionTest, HelpsTheWayThatTheJointMovesAndNotAtRest) {
  Random random(1);
  JointFriction friction(robot_);
  move(friction, 0.05, 1000, random, 0.0);
  for (int j = 0; j < static_cast<int>(n_); ++j) {
    const double stall = robot_.joints()[static_cast<std::size_t>(j)].motor.stall;
    EXPECT_EQ(friction.torque(j, 0.0), 0.0);
    for (int trial = 0; trial < 100; ++trial) {
      const double speed = random(-10.0, 10.0);
      EXPECT_GE(friction.torque(j, speed) * speed, 0.0);
      EXPECT_LE(std::abs(friction.torque(j, speed)), friction.share() * stall);
      EXPECT_EQ(friction.torque(j, -speed), -friction.torque(j, speed));
    }
    EXPECT_NEAR(friction.torque(j, robot_.omega()), friction.share() * stall, 1e-6 * stall);
  }
}

TEST_P(JointFrictionTest, StaysWithinItsBoundWhateverIsMeasured) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    JointFriction friction(robot_);
    for (int tick = 0; tick < 200; ++tick) {
      for (Eigen::Index j = 0; j < n_; ++j) {
        speed_[j] = random(-30.0, 30.0);
        error_[j] = random(-3.0, 3.0);
      }
      friction.update(speed_, error_);
      ASSERT_GE(friction.share(), 0.0);
      ASSERT_LE(friction.share(), 1.0 - robot_.profile().margin.torque);
    }
  }
}

}  // namespace
}  // namespace baton
