#include "baton/balance/torque_scale.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;

class TorqueScaleTest : public testing::TestWithParam<std::string> {
 protected:
  /// Servos hold joints whose load comes and goes as in a walk, and is `more` larger than the model says: what is not
  /// made up for shows as an error.
  /// @param ankles largest error of the ankles [rad]
  void bear(TorqueScale& scale, double more, int ticks, Random& random, double ankles = 0.0) {
    for (int tick = 0; tick < ticks; ++tick) {
      for (Eigen::Index j = 0; j < n_; ++j) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
        phase_[j] += robot_.omega() * robot_.profile().tick.period * random(0.5, 1.5);
        torque_[j] = joint.motor.stall * (0.25 + 0.2 * std::sin(phase_[j]));
        error_[j] = (more - scale.excess()) * torque_[j] / joint.gains.kp + offset_[j] + 1e-3 * random(-1.0, 1.0);
      }
      for (const Side side : kSides) {
        const std::vector<int>& leg = robot_.leg(side);
        for (const int ankle : {leg[leg.size() - 2], leg.back()})
          error_[ankle] += ankles * random(-1.0, 1.0);
      }
      scale.update(torque_, error_);
    }
  }

  /// @param time [1/ω]
  [[nodiscard]] int ticks(double time) const {
    return static_cast<int>(time / (robot_.omega() * robot_.profile().tick.period));
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
  VecX phase_ = VecX::LinSpaced(n_, 0.0, 6.0);
  VecX torque_ = VecX::Zero(n_);
  VecX error_ = VecX::Zero(n_);
  VecX offset_ = VecX::Zero(n_);
};

INSTANTIATE_TEST_SUITE_P(Robots, TorqueScaleTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(TorqueScaleTest, IsFoundSoonAndFollowsALoadThatChanges) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Random random(seed);
    const double more = random(-0.35, 0.6);
    for (double& angle : offset_)
      angle = random(-5e-4, 5e-4);
    TorqueScale scale(robot_);
    bear(scale, more, ticks(2.0), random);
    EXPECT_NEAR(scale.excess(), more, 0.03 + 0.22 * std::abs(more)) << seed << ": most of it within a step";
    bear(scale, 0.5 * more, ticks(20.0), random);
    EXPECT_NEAR(scale.excess(), 0.5 * more, 0.03) << seed;
  }
}

TEST_P(TorqueScaleTest, AnklesDoNotCount) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random quiet(seed);
    Random wild(seed);
    TorqueScale expected(robot_);
    TorqueScale scale(robot_);
    const VecX phase = phase_;
    bear(expected, 0.2, 200, quiet);
    phase_ = phase;
    bear(scale, 0.2, 200, wild, 0.5);
    EXPECT_EQ(scale.excess(), expected.excess());
  }
}

TEST_P(TorqueScaleTest, StaysWithinItsBoundWhateverIsMeasuredAndSaysNothingWithoutLoad) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Random random(seed);
    TorqueScale scale(robot_);
    for (int tick = 0; tick < 200; ++tick) {
      for (Eigen::Index j = 0; j < n_; ++j) {
        torque_[j] = random(-3.0, 3.0) * robot_.joints()[static_cast<std::size_t>(j)].motor.stall;
        error_[j] = random(-3.0, 3.0);
      }
      scale.update(torque_, error_);
      ASSERT_GE(scale.excess(), -0.4);
      ASSERT_LE(scale.excess(), 0.7);
    }
    TorqueScale hanging(robot_);
    hanging.update(VecX::Zero(n_), error_);
    EXPECT_EQ(hanging.excess(), 0.0);
  }
}

}  // namespace
}  // namespace baton
