#include "baton/model/heat.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/robots.hpp"

namespace baton {
namespace {

class HeatTest : public testing::Test {
 protected:
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  Thermal any_motor() {
    const double winding_time = std::exp(uniform(0.0, 4.0));
    return {uniform(0.1, 0.5), uniform(0.0, 1.0), winding_time, winding_time * std::exp(uniform(0.0, 4.0))};
  }
  Warmth any_warmth() { return {uniform(-0.5, 1.5), uniform(0.0, 1.5)}; }

  std::mt19937_64 random_{5};
};

TEST_F(HeatTest, IsTheSolutionOfItsDifferentialEquation) {
  for (int trial = 0; trial < 1000; ++trial) {
    const Thermal motor = any_motor();
    const Warmth start = any_warmth();
    const double torque = uniform(-1.0, 1.0);
    const double end = torque * torque / (motor.continuous * motor.continuous);
    const double time = motor.winding_time * uniform(0.01, 2.0);
    // By the classical Runge-Kutta method, each part by itself.
    const auto integrated = [&](double x, double to, double constant) {
      constexpr int kSteps = 200;
      const double h = time / kSteps / constant;
      for (int k = 0; k < kSteps; ++k) {
        const double k1 = to - x;
        const double k2 = to - (x + 0.5 * h * k1);
        const double k3 = to - (x + 0.5 * h * k2);
        const double k4 = to - (x + h * k3);
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      }
      return x;
    };
    const Warmth found = after(motor, start, torque, time);
    EXPECT_NEAR(found.winding, integrated(start.winding, motor.winding * end, motor.winding_time), 1e-8 * (1.0 + end));
    EXPECT_NEAR(found.housing, integrated(start.housing, (1.0 - motor.winding) * end, motor.housing_time),
                1e-8 * (1.0 + end));
  }
}

TEST_F(HeatTest, IsTheSameInOneStepOrInTwo) {
  for (int trial = 0; trial < 2000; ++trial) {
    const Thermal motor = any_motor();
    const Warmth start = any_warmth();
    const double torque = uniform(-1.0, 1.0);
    const double a = uniform(0.0, 100.0);
    const double b = uniform(0.0, 100.0);
    const Warmth two = after(motor, after(motor, start, torque, a), torque, b);
    EXPECT_NEAR(after(motor, start, torque, a + b).total(), two.total(), 1e-12 * (1.0 + steady(motor, torque)));
    EXPECT_EQ(after(motor, start, torque, 0.0), start);
    EXPECT_EQ(after(motor, start, torque, a), after(motor, start, -torque, a)) << "either way round";
  }
}

TEST_F(HeatTest, NoMomentWithMoreTorqueLeavesAMotorCooler) {
  for (int trial = 0; trial < 2000; ++trial) {
    const Thermal motor = any_motor();
    Warmth less = any_warmth();
    Warmth more{less.winding + uniform(0.0, 0.2), less.housing + uniform(0.0, 0.2)};
    for (int k = 0; k < 10; ++k) {
      const double torque = uniform(0.0, 1.0);
      const double time = uniform(0.0, motor.winding_time);
      less = after(motor, less, torque * uniform(-1.0, 1.0), time);
      more = after(motor, more, torque, time);
      EXPECT_LE(less.winding, more.winding + 1e-12);
      EXPECT_LE(less.housing, more.housing + 1e-12);
    }
  }
}

TEST_F(HeatTest, ATorqueHeldForEverLeadsToItsSteadyValue) {
  for (int trial = 0; trial < 2000; ++trial) {
    const Thermal motor = any_motor();
    const double torque = uniform(0.0, 1.0);
    const Warmth end = after(motor, any_warmth(), torque, 50.0 * motor.housing_time);
    EXPECT_NEAR(end.total(), steady(motor, torque), 1e-9 * (1.0 + steady(motor, torque)));
    EXPECT_NEAR(end.winding, motor.winding * steady(motor, torque), 1e-9 * (1.0 + steady(motor, torque)));
    // The continuous torque is what the limit is reached with, and from below it is never passed.
    EXPECT_DOUBLE_EQ(steady(motor, motor.continuous), 1.0);
    Warmth cold;
    for (int k = 0; k < 20; ++k) {
      cold = after(motor, cold, motor.continuous * uniform(-1.0, 1.0), uniform(0.0, motor.housing_time));
      EXPECT_LE(cold.total(), 1.0);
    }
  }
}

TEST_F(HeatTest, AMotorWithoutConstantsNeverGetsWarm) {
  EXPECT_EQ(steady({}, 1.0), 0.0);
  EXPECT_EQ(after({}, {}, 1.0, 1e6), Warmth{});
}

TEST_F(HeatTest, TheHottestIsTheOneNearestToItsLimit) {
  EXPECT_EQ(hottest({}).joint, -1);
  EXPECT_EQ(hottest(Heat(3)).joint, -1) << "cold";
  const Heat heat{{0.1, 0.1}, {0.3, 0.2}, {0.0, 0.4}};
  EXPECT_EQ(hottest(heat).joint, 1);
  EXPECT_DOUBLE_EQ(hottest(heat).total, 0.5);
  const Heat warmed = at_least(heat, 0.45);
  EXPECT_EQ(warmed[1], heat[1]);
  EXPECT_DOUBLE_EQ(warmed[0].total(), 0.45);
  EXPECT_DOUBLE_EQ(warmed[2].total(), 0.45);
}

class HeatModelTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const HeatModel model_{robot_};
};

INSTANTIATE_TEST_SUITE_P(Robots, HeatModelTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(HeatModelTest, StepsEachMotorByItsOwnTorqueAndConstants) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double period = robot_.profile().tick.period;
  const std::size_t n = robot_.joints().size();
  Heat heat = model_.cold();
  Heat expected = heat;
  ASSERT_EQ(heat.size(), n);
  ASSERT_TRUE(model_.limited());
  VecX torque(n);
  for (int k = 0; k < 1000; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const Motor& motor = robot_.joints()[j].motor;
      const double share = uniform(random);
      torque[static_cast<Eigen::Index>(j)] = share * motor.stall;
      expected[j] = after(motor.thermal, expected[j], share, period);
    }
    model_.step(heat, torque);
    for (std::size_t j = 0; j < n; ++j)
      ASSERT_NEAR(heat[j].total(), expected[j].total(), 1e-9);
  }
  const Hottest held = model_.held(torque);
  const auto joint = static_cast<std::size_t>(held.joint);
  for (int k = 0; k < 2000000 / 5; ++k)
    model_.step(heat, torque);
  EXPECT_EQ(hottest(heat).joint, held.joint);
  EXPECT_NEAR(heat[joint].total(), held.total, 0.02 * held.total) << "2000 s";
}

}  // namespace
}  // namespace baton
