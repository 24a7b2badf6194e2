/// Motions that are replaced on their way.
#include <gmock/gmock.h>

#include <random>

#include "baton/proving/scenario.hpp"
#include "baton/run/simulation.hpp"
#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Trip;

Command stick(Part part, const Vec6& axes) {
  Command command;
  command.guide = part;
  command.axes = axes;
  return command;
}

Vec6 axes(double x, double y, double yaw) {
  Vec6 a = Vec6::Zero();
  a << x, y, 0, 0, 0, yaw;
  return a;
}

class FlowTest : public testing::TestWithParam<const char*> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const double period_ = robot_.profile().tick.period;
  const double size_ = robot_.profile().stance.com_height / 0.26;
  const double second_ = std::sqrt(size_) / period_;  ///< ticks
};

INSTANTIATE_TEST_SUITE_P(Robots, FlowTest, testing::Values("mighty", "scaled"),
                         [](const auto& robot) { return std::string(robot.param); });

TEST_P(FlowTest, WhateverReplacesAMotionGoesOnFromItsStateAndEndsAtRest) {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int replaced = 0;
  int in_the_air = 0;
  for (int trial = 0; trial < 6; ++trial) {
    Trip walk(robot_);
    Command command;
    MotionSample expected;
    bool moving = false;
    VecX q_before;
    VecX q_now;
    for (int k = 0; k < static_cast<int>(12 * second_); ++k) {
      if (random() % 40 == 0) {
        command.guide = kParts[random() % kParts.size()];
        for (double& axis : command.axes)
          axis = random() % 3 == 0 ? 0.0 : uniform(random);
        command.lift = {random() % 4 == 0 ? 0.6 : 0.0, random() % 4 == 0 ? 0.6 : 0.0};
      }
      const long committed = walk.navigator().committed();
      const JointTarget target = walk.step(command);
      const Motion* motion = walk.navigator().motion();
      if (walk.navigator().committed() != committed && moving) {
        // The new motion begins where the old one would have been, as fast.
        ASSERT_EQ(motion->samples.front().q, expected.q);
        ASSERT_LT((motion->samples.front().com - expected.com).norm(), 1e-9);
        ASSERT_LT((motion->samples.front().dcom - expected.dcom).norm(), 1e-9);
        ++replaced;
        in_the_air += expected.contact.left && expected.contact.right ? 0 : 1;
      }
      if (motion != nullptr && walk.navigator().committed() != committed) {
        ASSERT_TRUE(motion->end.dq.isZero(0.0));
        ASSERT_FALSE(walk.navigator().planned()->motion.certificate().margins.empty());
      }
      // What the joints are told never jumps.
      if (k > 1) {
        const VecX jump = (target.q - 2.0 * q_now + q_before) / (period_ * period_);
        ASSERT_LT(jump.cwiseAbs().maxCoeff(), robot_.profile().margin.acceleration * (1.0 + 1e-6)) << k;
      }
      q_before = q_now;
      q_now = target.q;
      const bool was_moving = motion != nullptr;
      const auto next = [&] {
        for (std::size_t i = 0; i + 1 < motion->samples.size(); ++i) {
          if (&motion->samples[i] == &walk.navigator().sample()) return motion->samples[i + 1];
        }
        return motion->rest;
      };
      if (was_moving) expected = next();
      moving = was_moving && !(expected.dq.isZero(0.0) && expected.q == motion->end.q);
    }
  }
  EXPECT_GT(replaced, 60);
  EXPECT_GT(in_the_air, 10);
}

TEST_P(FlowTest, AHeldStickWalksWithoutRestInAnyDirectionAndFasterThanStepByStep) {
  const int ticks = static_cast<int>(6 * second_);
  for (const Vec6& way : {axes(1, 0, 0), axes(-1, 0, 0), axes(0, 1, 0), axes(0, -1, 0), axes(1, 1, 0), axes(1, -1, 0),
                          axes(-1, 1, 0), axes(-1, -1, 0)}) {
    std::array<double, 2> speed{};
    for (const Gait gait : {Gait::stop, Gait::flow}) {
      Trip walk(robot_, {.gait = gait});
      const Vec2 begin = walk.posture().com.head<2>();
      int rests = 0;
      for (int k = 0; k < ticks; ++k) {
        walk.step(stick(Part::trunk, way));
        rests += walk.navigator().motion() == nullptr && walk.navigator().committed() > 0 ? 1 : 0;
      }
      speed[gait == Gait::flow ? 1 : 0] = (walk.posture().com.head<2>() - begin).dot(way.head<2>().normalized());
      if (gait == Gait::flow) {
        EXPECT_EQ(rests, 0) << way.transpose();
      }
    }
    EXPECT_GT(speed[1], 1.5 * speed[0]) << way.transpose();
  }
}

TEST_P(FlowTest, ItTurnsOnTheSpot) {
  std::array<double, 2> turned{};
  for (const Gait gait : {Gait::stop, Gait::flow}) {
    Trip walk(robot_, {.gait = gait});
    double last = yaw_of(walk.posture().trunk);
    double& sum = turned[gait == Gait::flow ? 1 : 0];
    for (int k = 0; k < static_cast<int>(6 * second_); ++k) {
      walk.step(stick(Part::trunk, axes(0, 0, 1)));
      const double yaw = yaw_of(walk.posture().trunk);
      sum += wrap_angle(yaw - std::exchange(last, yaw));
    }
    EXPECT_LT(walk.posture().com.head<2>().norm(), 0.15 * size_);
  }
  EXPECT_GT(turned[1], 1.4 * turned[0]);
}

TEST_P(FlowTest, LetGoOfItStopsWithinTheNextStep) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 12; ++trial) {
    Trip walk(robot_);
    const int held = static_cast<int>((2.0 + 0.01 * static_cast<double>(random() % 100)) * second_);
    for (int k = 0; k < held; ++k)
      walk.step(stick(Part::trunk, axes(1, trial % 3 - 1, 0)));
    const long committed = walk.navigator().committed();
    int landings = 0;
    int ticks = 0;
    bool both = walk.navigator().sample().contact.left && walk.navigator().sample().contact.right;
    for (; walk.navigator().motion() != nullptr; ++ticks) {
      walk.step({});
      const BySide<bool>& contact = walk.navigator().sample().contact;
      const bool now = contact.left && contact.right;
      landings += now && !both ? 1 : 0;
      both = now;
      ASSERT_LT(ticks, 2.0 * second_);
    }
    EXPECT_LE(landings, 1);
    EXPECT_EQ(walk.navigator().committed(), committed);
  }
}

TEST_P(FlowTest, AFootIsSentElsewhereWhileItIsInTheAir) {
  Trip walk(robot_);
  const Vec3 stood = walk.posture().sole.left.p;
  while (walk.navigator().phase() != Phase::single_right)
    walk.step(stick(Part::left_foot, axes(0.6, 0, 0)));
  const long committed = walk.navigator().committed();
  for (int k = 0; k < static_cast<int>(0.1 * second_); ++k)
    walk.step(stick(Part::left_foot, axes(0, 0.6, 0)));
  EXPECT_EQ(walk.navigator().committed(), committed + 1);
  while (walk.navigator().motion() != nullptr)
    walk.step({});
  const Vec3 moved = walk.posture().sole.left.p - stood;
  EXPECT_NEAR(moved.x(), 0.0, 1e-3 * size_);
  EXPECT_NEAR(moved.y(), 0.6 * robot_.profile().reach.foot, 1e-3 * size_);
}

TEST_P(FlowTest, AHandMovesWhileAStepIsUnderWay) {
  Trip walk(robot_);
  while (walk.navigator().phase() != Phase::single_left && walk.navigator().phase() != Phase::single_right)
    walk.step(stick(Part::trunk, axes(1, 0, 0)));
  const Vec3 goal = walk.navigator().motion()->end.hand.left.p;
  int ticks = 0;
  Vec6 up = Vec6::Zero();
  up[2] = 1.0;
  const long committed = walk.navigator().committed();
  while (walk.navigator().committed() == committed && ticks < static_cast<int>(0.15 * second_)) {
    walk.step(stick(Part::left_hand, up));
    ++ticks;
  }
  ASSERT_EQ(walk.navigator().committed(), committed + 1);
  EXPECT_EQ(walk.navigator().motion()->goal.guided, Part::left_hand);
  EXPECT_GT(walk.navigator().motion()->end.hand.left.p.z(), goal.z() + 0.3 * robot_.profile().reach.hand);
  EXPECT_LE(ticks, robot_.profile().tick.lookahead + static_cast<int>(0.1 / period_) + 1);
}

TEST_P(FlowTest, AFootThatIsAboutToLeaveTheGroundIsNotSentElsewhere) {
  std::mt19937_64 random(47);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int replaced_before = 0;
  Trip walk(robot_);
  Command command;
  int lift_off = 0;  // ticks of the motion under way until a foot leaves the ground; 0: none does
  int at = 0;
  for (int k = 0; k < static_cast<int>(120 * second_); ++k) {
    if (random() % 12 == 0)
      command = stick(kParts[random() % kParts.size()], axes(uniform(random), uniform(random), 0));
    const long committed = walk.navigator().committed();
    const bool moved = walk.navigator().motion() != nullptr;
    walk.step(command);
    ++at;
    if (walk.navigator().committed() == committed) continue;
    if (moved && at < lift_off) {
      EXPECT_GE((lift_off - at) * period_, 0.04 - 1e-9);
      ++replaced_before;
    }
    const Motion& motion = *walk.navigator().motion();
    const bool leaves = motion.goal.swing && motion.phases.size() > 1 && motion.phases.front().contact.left &&
                        motion.phases.front().contact.right;
    lift_off = leaves ? motion.phases.front().ticks : 0;
    at = 0;
  }
  EXPECT_GT(replaced_before, 10);
}

TEST_P(FlowTest, AHandLeadsTheRobotAsFarAsItIsGuided) {
  // Beyond the arm's reach the body follows, by steps and without a rest.
  for (const auto& [x, y] : {std::pair(1.0, 0.0), {-1.0, 0.0}, {0.5, 0.0}}) {
    Trip walk(robot_);
    int longest = 0;  // time without a motion
    int rests = 0;
    for (int k = 0; k < static_cast<int>(16 * second_); ++k) {
      walk.step(stick(Part::left_hand, axes(x, y, 0)));
      rests = walk.navigator().motion() == nullptr ? rests + 1 : 0;
      longest = std::max(longest, rests);
    }
    const Vec3 way = walk.posture().com - walk.home().com;
    const Vec2 wish = Vec2(x, y).normalized();
    EXPECT_GT(way.head<2>().dot(wish), 0.2 * size_) << x << ", " << y;
    EXPECT_NEAR(way.z(), 0.0, 0.03 * size_) << x << ", " << y;
    EXPECT_LT(longest, second_) << x << ", " << y;
  }
}

TEST_P(FlowTest, AfterAHandHasLedTheBodyAsideAndDownTheTrunkStillWalks) {
  Trip walk(robot_);
  Vec6 aside = axes(0, 0.5, 0);
  aside[2] = -0.5;
  for (int k = 0; k < static_cast<int>(3.7 * second_); ++k)
    walk.step(stick(Part::left_hand, aside));
  const Posture led = walk.posture();
  EXPECT_LT(led.com.z(), walk.home().com.z() - 0.01 * size_);
  for (int k = 0; k < static_cast<int>(2.4 * second_); ++k)
    walk.step(stick(Part::trunk, axes(1, 0, 0)));
  EXPECT_GT(walk.posture().com.x(), led.com.x() + 2.0 * robot_.profile().reach.trunk);
}

TEST_P(FlowTest, AnAnswerThatIsNotThereIsDroppedAndTheMotionEndsAtRest) {
  Trip walk(robot_);
  for (int k = 0; k < static_cast<int>(1.5 * second_); ++k)
    walk.step(stick(Part::trunk, axes(1, 0, 0)));
  const long committed = walk.navigator().committed();
  // The planner does not answer any more.
  for (int k = 0; k < static_cast<int>(3.0 * second_); ++k)
    walk.step(stick(Part::trunk, axes(1, 0, 0)), false);
  EXPECT_LE(walk.navigator().committed(), committed + 1);
  EXPECT_EQ(walk.navigator().phase(), Phase::hold);
  EXPECT_GT(walk.navigator().dropped(), 1);
  // And answers again.
  for (int k = 0; k < static_cast<int>(3.0 * second_); ++k)
    walk.step(stick(Part::trunk, axes(1, 0, 0)));
  EXPECT_GT(walk.navigator().committed(), committed + 3);
}

/// A foot in the air moves with the trunk, so it lands off target by the trunk's error. The next motion begins from
/// both soles: by the stance foot alone it would begin with that error, and the one after it with the opposite.
TEST(FlowInPhysics, AMotionBeginsFromTheFootThatLandedToo) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  const double height = robot.profile().stance.com_height;
  int landings = 0;
  double apart = 0.0;
  double off = 0.0;
  for (const std::uint64_t seed : {0, 1, 2, 3, 4}) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant_of(scenario_named("hip"), robot, seed, 1.0);
    Simulation simulation(robot, world, Simulation::On::sim, {.physics = parameters});
    Session& session = simulation.session();
    const Navigator& navigator = session.navigator();
    long committed = 0;
    bool flew = false;
    while (session.t() < 8.0 && !session.fallen()) {
      session.step(stick(Part::trunk, axes(1, seed > 2 ? 1 : 0, 0)));
      const MotionSample& planned = navigator.sample();
      const bool stands = planned.contact.left && planned.contact.right;
      if (navigator.committed() > committed && flew && stands) {
        ++landings;
        BySide<Vec2> error;
        for (const Side side : kSides)
          error[side] = (navigator.state().sole[side].p - planned.sole[side].p).head<2>();
        apart += (error.left - error.right).norm();
        off += 0.5 * (error.left + error.right).norm();
      }
      committed = navigator.committed();
      flew = !stands;
    }
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
  }
  EXPECT_GT(landings, 12);
  EXPECT_GT(apart / landings, 3e-3 * height) << "feet land too well to tell";
  EXPECT_LT(off, 0.3 * apart) << "half of it, by the stance foot alone";
}

}  // namespace
}  // namespace baton
