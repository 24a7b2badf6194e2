/// Motors that get hot: what is predicted, what is allowed, and what a hot robot does.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "baton/plan/strategy.hpp"
#include "tests/guide/commands.hpp"
#include "tests/navigate/trip.hpp"
#include "tests/support/mirror.hpp"
#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

using test::push;
using test::Trip;

class MotorHeatTest : public testing::TestWithParam<std::string> {
 protected:
  /// The robot with other thermal constants in all motors.
  static RobotModel with(const RobotModel& robot, const Thermal& thermal) {
    Profile profile = robot.profile();
    for (const Joint& joint : robot.joints())
      profile.heat[joint.name] = thermal;
    return RobotModel(profile);
  }
  [[nodiscard]] static double height(const Trip& trip) {
    const Posture now = trip.posture();
    return now.com.z() - 0.5 * (now.sole.left.p.z() + now.sole.right.p.z());
  }
  [[nodiscard]] static double heat(const Trip& trip) { return trip.navigator().thermometer().hottest().total; }
  [[nodiscard]] static bool hot(const Trip& trip) { return trip.navigator().thermometer().hot(); }
  /// Steps until the condition holds; false if it does not within `time` [s of mighty].
  template <typename Condition>
  bool until(Trip& trip, const Command& command, double time, const Condition& condition) const {
    for (long left = std::lround(time * second_); left > 0; --left) {
      trip.step(command);
      if (condition()) return true;
    }
    return false;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const double unit_ = std::sqrt(robot_.profile().stance.com_height / 0.26);  ///< of time, in mighty's
  const double second_ = unit_ / robot_.profile().tick.period;                ///< [ticks]
  /// Hot after seconds, not minutes.
  const RobotModel small_ = with(robot_, {0.25, 0.2, 3.0 * unit_, 30.0 * unit_});
};

INSTANTIATE_TEST_SUITE_P(Robots, MotorHeatTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(MotorHeatTest, ACoolRobotMovesAsOneWhoseMotorsNeverGetWarm) {
  const RobotModel tireless = with(robot_, {});
  Trip trip(robot_);
  Trip other(tireless);
  std::mt19937_64 random(3);
  Command command;
  for (long k = 0; k < std::lround(20 * second_); ++k) {
    if (k % std::lround(0.7 * second_) == 0) command = test::random_command(random);
    const VecX q = other.step(command).q;
    ASSERT_EQ(trip.step(command).q, q) << k;
    ASSERT_FALSE(hot(trip));
  }
  EXPECT_GT(heat(trip), 0.05);
  EXPECT_EQ(heat(other), 0.0);
}

TEST_P(MotorHeatTest, AHotRobotRestsStraighterUntilItHasCooledAndGoesOn) {
  Trip trip(small_);
  const Command walk = push(Part::trunk, 0);
  const double before = height(trip);
  ASSERT_TRUE(until(trip, walk, 30.0, [&] { return hot(trip); }));
  trip.step(walk);
  const auto* changed = find_event<HeatChanged>(trip.navigator().events());
  ASSERT_NE(changed, nullptr);
  EXPECT_TRUE(changed->hot);
  EXPECT_GE(heat(trip), kHot);
  const long committed = trip.navigator().committed();
  ASSERT_TRUE(until(trip, walk, 5.0, [&] { return trip.navigator().purpose() == Purpose::cool; }));
  EXPECT_EQ(trip.navigator().committed(), committed + 1) << "the step under way is the last";
  ASSERT_TRUE(until(trip, walk, 4.0, [&] { return trip.navigator().motion() == nullptr; }));
  EXPECT_GT(height(trip), before + 0.02 * before);
  const double rested = heat(trip);
  ASSERT_TRUE(until(trip, walk, 60.0, [&] { return !hot(trip); }));
  EXPECT_LT(heat(trip), rested);
  EXPECT_EQ(trip.navigator().committed(), committed + 1);
  EXPECT_TRUE(until(trip, walk, 2.0, [&] { return trip.navigator().purpose() == Purpose::follow; })) << "goes on";
}

TEST_P(MotorHeatTest, WhateverTheStickNoMotorPassesItsLimitAndTheRobotRecovers) {
  long hot_ticks = 0;
  double most = 0.0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    std::mt19937_64 random(seed);
    Trip trip(small_);
    Command command;
    for (long k = 0; k < std::lround(60 * second_); ++k) {
      if (random() % 150 == 0) command = test::random_command(random);
      if (random() % 1500 == 0) command.recall = random() % 2 == 0 ? Recall::retrace : Recall::home;
      trip.step(command);
      hot_ticks += hot(trip) ? 1 : 0;
      most = std::max(most, heat(trip));
    }
    EXPECT_TRUE(until(trip, {}, 60.0, [&] { return !hot(trip) && trip.navigator().motion() == nullptr; })) << seed;
    EXPECT_TRUE(
        until(trip, push(Part::trunk, 0), 20.0, [&] { return trip.navigator().purpose() == Purpose::follow; }) ||
        until(trip, push(Part::trunk, 0, -1.0), 20.0, [&] { return trip.navigator().purpose() == Purpose::follow; }))
        << seed;
  }
  EXPECT_GT(hot_ticks, std::lround(20 * second_));
  // Planned and commanded torques differ: in how the soles share the load, and where a motion is replaced. These motors
  // warm up fifteen times as quickly as mighty's.
  EXPECT_LE(most, 1.03);
}

TEST_P(MotorHeatTest, AHotRobotPutsAFootDownThatIsHeldUp) {
  Trip trip(small_);
  Command lift{.guide = Part::left_foot};
  lift.lift.left = 1.0;
  ASSERT_TRUE(until(trip, lift, 3.0, [&] { return !trip.navigator().sample().contact.left; }));
  ASSERT_TRUE(until(trip, lift, 30.0, [&] { return hot(trip); }));
  ASSERT_TRUE(until(trip, lift, 4.0, [&] { return trip.navigator().sample().contact.left; }));
  EXPECT_LE(heat(trip), 1.0);
  EXPECT_TRUE(until(trip, lift, 60.0, [&] { return !trip.navigator().sample().contact.left; })) << "up again";
  EXPECT_FALSE(hot(trip));
}

TEST_P(MotorHeatTest, ARobotRisesByItselfFromASquatThatItCannotHold) {
  Trip trip(small_);
  const double before = height(trip);
  ASSERT_TRUE(until(trip, push(Part::trunk, 2, -1.0), 3.0, [&] { return height(trip) < 0.93 * before; }));
  ASSERT_TRUE(until(trip, {}, 3.0, [&] { return trip.navigator().motion() == nullptr; }));
  EXPECT_FALSE(hot(trip));
  ASSERT_TRUE(until(trip, {}, 60.0, [&] { return trip.navigator().purpose() == Purpose::cool; }));
  EXPECT_LE(heat(trip), 1.0);
  ASSERT_TRUE(until(trip, {}, 3.0, [&] { return trip.navigator().motion() == nullptr; }));
  EXPECT_GT(height(trip), before);
  ASSERT_TRUE(until(trip, {}, 60.0, [&] { return !hot(trip); }));
  EXPECT_FALSE(until(trip, {}, 20.0, [&] { return hot(trip) || trip.navigator().motion() != nullptr; })) << "for ever";
}

TEST_P(MotorHeatTest, AStopIsObeyedHoweverHot) {
  Trip trip(small_);
  ASSERT_TRUE(until(trip, push(Part::trunk, 0), 30.0, [&] { return hot(trip); }));
  ASSERT_TRUE(until(trip, {.recall = Recall::stop}, 3.0, [&] { return trip.navigator().motion() == nullptr; }));
  EXPECT_FALSE(until(trip, {.recall = Recall::stop}, 3.0, [&] { return trip.navigator().motion() != nullptr; }))
      << "it does not rise while a stop is held";
}

TEST_P(MotorHeatTest, WhatIsPredictedIsWhatComes) {
  Trip trip(robot_);
  std::mt19937_64 random(11);
  int compared = 0;
  for (int k = 0; k < 30; ++k) {
    const Command command = test::in_turn(static_cast<std::size_t>(k), random);
    until(trip, command, 0.1, [&] { return trip.navigator().motion() != nullptr; });
    const PlannedMotion* planned = trip.navigator().planned();
    if (planned == nullptr) continue;
    const long segment = trip.navigator().segment();
    const Heat predicted = planned->motion->end.heat;
    ASSERT_EQ(predicted.size(), robot_.joints().size());
    // Until it ends: what replaces it does not count.
    until(trip, {.guide = command.guide, .lift = command.lift}, 5.0,
          [&] { return trip.navigator().segment() != segment; });
    if (trip.navigator().motion() != nullptr) continue;
    ++compared;
    for (std::size_t j = 0; j < predicted.size(); ++j)
      EXPECT_NEAR(trip.navigator().thermometer().heat()[j].total(), predicted[j].total(), 0.01) << k << " joint " << j;
  }
  EXPECT_GT(compared, 15);
}

TEST_P(MotorHeatTest, AMotionIsRefusedThatWouldPassTheLimitOnItsWay) {
  const World world = World::load("flat");
  Verifier verifier(robot_, world);
  const Limits limits = Limits::normal(robot_.profile());
  for (const VerifiedMotion& made : test::sample_motions(GetParam())) {
    Motion motion = *made;
    const auto verified = [&](double housing) {
      motion.heat.assign(robot_.joints().size(), {0.0, housing});
      const auto verdict = verifier.verify(motion, {}, limits);
      return std::holds_alternative<VerifiedMotion>(verdict);
    };
    motion.heat.clear();
    const auto cold = verifier.verify(motion, {}, limits);
    double gained = 0.0;
    for (const Margin& margin : std::get<VerifiedMotion>(cold).certificate().margins) {
      if (margin.quantity == Reason::motor_heat) gained = margin.value;
    }
    ASSERT_GT(gained, 0.0);
    EXPECT_TRUE(verified(0.999 - gained)) << gained;
    // Too hot already: it must be able to move to where it cools.
    EXPECT_TRUE(verified(1.02)) << gained;
  }
  // Motors that warm up twenty times as quickly.
  Profile profile = robot_.profile();
  for (auto& [joint, thermal] : profile.heat)
    thermal.winding_time *= 0.05;
  const RobotModel quick(profile);
  Verifier quick_verifier(quick, world);
  int refused = 0;
  for (const VerifiedMotion& made : test::sample_motions(GetParam())) {
    Motion motion = *made;
    motion.heat.assign(robot_.joints().size(), {0.0, 0.9});
    const auto verdict = quick_verifier.verify(motion, {}, limits);
    const auto* refusal = std::get_if<Refusal>(&verdict);
    if (refusal == nullptr) continue;
    ++refused;
    EXPECT_EQ(refusal->reason, Reason::motor_heat);
    EXPECT_GT(refusal->value, 1.0);
    EXPECT_EQ(refusal->limit, 1.0);
    EXPECT_FALSE(refusal->where.empty());
  }
  EXPECT_GT(refused, 5);
}

TEST_P(MotorHeatTest, AMirroredMotionHeatsTheMotorsOfTheOtherSide) {
  const RobotModel& robot = test::symmetric_robot(GetParam());
  const test::Mirror mirror(robot);
  const World world = World::load("flat");
  const Guide guide(robot, world);
  Planner planner(robot, world);
  Verifier verifier(robot, world);
  const Limits limits = Limits::normal(robot.profile());
  const auto totals = [&](const Motion& motion) {
    VecX v(motion.end.heat.size());
    for (std::size_t j = 0; j < motion.end.heat.size(); ++j)
      v[static_cast<Eigen::Index>(j)] = motion.end.heat[j].total();
    return v;
  };
  GuideContext context = test::at_home(robot);
  std::mt19937_64 random(9);
  int compared = 0;
  for (std::size_t k = 0; k < 25; ++k) {
    const GuideResult guided = guide.goals(context, test::in_turn(k, random));
    const auto* goals = std::get_if<std::vector<Goal>>(&guided);
    if (goals == nullptr) continue;
    const PlanResult planned = planner.plan(context.from, goals->front(), context.anchor, limits);
    const auto* found = std::get_if<PlannedMotion>(&planned);
    if (found == nullptr) continue;
    Motion from_cold = *found->motion;
    from_cold.heat.clear();
    const auto one = verifier.verify(from_cold, context.anchor, limits);
    const auto two = verifier.verify(mirror.of(from_cold), test::Mirror::of(context.anchor), limits);
    if (!std::holds_alternative<VerifiedMotion>(one) || !std::holds_alternative<VerifiedMotion>(two)) continue;
    ++compared;
    const VecX other = totals(*std::get<VerifiedMotion>(two)).cwiseAbs();
    EXPECT_LT((mirror.joints(totals(*std::get<VerifiedMotion>(one))).cwiseAbs() - other).cwiseAbs().maxCoeff(), 1e-6);
    test::go_on(context, *found->motion);
  }
  EXPECT_GT(compared, 10);
}

TEST_P(MotorHeatTest, WhatARestKeepsWarmIsNotWaitedFor) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0.05, 0.9);
  for (int k = 0; k < 200; ++k) {
    const double rest = uniform(random);  // final rise of the motor with the largest load
    Thermometer thermometer(small_);
    JointTarget target;
    target.tau = target.dq = VecX::Zero(robot_.nv() - 6);
    const Joint& joint = small_.joints().front();
    Measurement measured;
    const auto load = [&](double final) {
      target.tau[0] = std::sqrt(final) * joint.motor.thermal.continuous * joint.motor.stall;
      thermometer.update(measured, target);
    };
    while (!thermometer.hot())
      load(3.0);
    // The housing may make it hot once more.
    long waits = 0;
    for (long tick = 0; tick < std::lround(600.0 * second_); ++tick) {
      load(rest);
      waits += thermometer.hot() ? 1 : 0;
    }
    EXPECT_FALSE(thermometer.hot()) << rest;
    EXPECT_LT(waits, std::lround(100.0 * second_)) << rest;
    while (!thermometer.hot() && thermometer.hottest().total < 1.0)
      load(3.0);
    EXPECT_LT(thermometer.hottest().total, std::max(0.81, std::min(0.951, rest + 0.13))) << rest;
  }
}

TEST_P(MotorHeatTest, TorquesThatCannotBeAreTakenAsCommanded) {
  const Eigen::Index n = robot_.nv() - 6;
  JointTarget target;
  target.tau = VecX::Constant(n, 0.3);
  target.dq = VecX::Constant(n, 0.1);
  Measurement measured;
  measured.dq = VecX::Constant(n, -2.0);
  Thermometer commanded(robot_);
  Thermometer faulty(robot_);
  Thermometer told(robot_);
  for (int k = 0; k < 1000; ++k) {
    measured.torque.resize(0);
    commanded.update(measured, target);
    for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(), -1e9}) {
      if (k % 3 == 0) measured.torque = VecX::Constant(n, wrong);
    }
    if (measured.torque.size() == 0) measured.torque = VecX::Constant(n, std::nan(""));
    faulty.update(measured, target);
    for (Eigen::Index j = 0; j < n; ++j)
      measured.torque[j] = -2.0 * robot_.joints()[static_cast<std::size_t>(j)].motor.damping;
    told.update(measured, target);  // back-EMF alone: no current
  }
  EXPECT_EQ(faulty.heat(), commanded.heat());
  EXPECT_GT(commanded.hottest().total, 0.0);
  EXPECT_EQ(told.hottest().total, 0.0);
}

}  // namespace
}  // namespace baton
