/// To rest at once: by the stop button, and where a way back is let go of.
#include <gmock/gmock.h>

#include <random>

#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Trip;

Command recall(Recall recall) {
  Command command;
  command.recall = recall;
  return command;
}

class StopTest : public testing::TestWithParam<const char*> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const double period_ = robot_.profile().tick.period;
  const double second_ = std::sqrt(robot_.profile().stance.com_height / 0.26) / period_;  ///< ticks

  static Command random_stick(std::mt19937_64& random) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Command command;
    command.guide = random() % 3 == 0 ? kParts[random() % kParts.size()] : Part::trunk;
    for (double& axis : command.axes)
      axis = random() % 3 == 0 ? 0.0 : uniform(random);
    return command;
  }
  static bool rests(const Trip& trip) { return trip.navigator().motion() == nullptr; }
  /// Ticks until the robot rests while this is held.
  int ticks_to_rest(Trip& trip, const Command& command) const {
    int ticks = 0;
    for (; !rests(trip); ++ticks) {
      trip.step(command);
      EXPECT_LT(ticks, 20 * second_);
      if (ticks > 20 * second_) break;
    }
    return ticks;
  }
  static double distance(const Posture& a, const Posture& b) {
    double most = (a.com - b.com).norm();
    for (const Side side : kSides)
      most = std::max(most, (a.sole[side].p - b.sole[side].p).norm());
    return most;
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, StopTest, testing::Values("mighty", "scaled"),
                         [](const auto& robot) { return std::string(robot.param); });

TEST_P(StopTest, StopsNeverLaterThanLettingGoAndMostlySooner) {
  int sooner = 0;
  int moving = 0;
  double stopping = 0.0;
  double letting_go = 0.0;
  for (int trial = 0; trial < 30; ++trial) {
    std::array<int, 2> ticks{};
    bool moves = false;
    for (const int stops : {0, 1}) {
      std::mt19937_64 random(100 + trial);
      Trip trip(robot_);
      for (int k = 0; k < 3; ++k) {
        const Command command = random_stick(random);
        for (int left = static_cast<int>(random() % static_cast<unsigned>(1.5 * second_)); left > 0; --left)
          trip.step(command);
      }
      moves = !rests(trip);
      ticks[static_cast<std::size_t>(stops)] = ticks_to_rest(trip, stops == 1 ? recall(Recall::stop) : Command{});
      EXPECT_TRUE(trip.posture().contact.left && trip.posture().contact.right);
    }
    if (!moves) continue;
    ++moving;
    EXPECT_LE(ticks[1], ticks[0]) << trial;
    if (ticks[1] < ticks[0]) ++sooner;
    stopping += ticks[1] * period_;
    letting_go += ticks[0] * period_;
  }
  EXPECT_GE(moving, 20);
  EXPECT_GE(sooner, moving / 2);
  EXPECT_LT(stopping, 0.8 * letting_go);
  RecordProperty("stopping_s", std::to_string(stopping / moving));
  RecordProperty("letting_go_s", std::to_string(letting_go / moving));
}

TEST_P(StopTest, PutsDownAFootThatIsInTheAirHoweverItGotThere) {
  int up = 0;
  for (int trial = 0; trial < 24; ++trial) {
    std::mt19937_64 random(300 + trial);
    std::uniform_real_distribution<double> uniform(0.2, 1.0);
    const Side side = random() % 2 == 0 ? Side::left : Side::right;
    Trip trip(robot_);
    Command command;
    command.guide = foot(side);
    const auto hold = [&](double seconds) {
      for (long k = std::lround(seconds * static_cast<double>(second_)); k > 0; --k)
        trip.step(command);
    };
    command.axes[0] = uniform(random);
    hold(uniform(random));
    command.axes.setZero();
    command.lift[side] = uniform(random);
    hold(1.0 + uniform(random));
    command.axes[1] = sign_of(side) * uniform(random);
    hold(uniform(random));
    command.axes.setZero();
    command.lift[side] = 0.0;
    hold(0.2 * uniform(random));  // the lever is back, and the foot on its way down, or not yet
    up += trip.posture().contact[side] ? 0 : 1;
    command.recall = Recall::stop;
    hold(4.0);
    EXPECT_TRUE(rests(trip)) << trial;
    const BySide<bool>& contact = trip.navigator().sample().contact;
    EXPECT_TRUE(contact.left && contact.right) << trial;
  }
  RecordProperty("up", up);
}

TEST_P(StopTest, NothingBeginsWhileItIsHeldWhateverTheStickDoes) {
  Trip trip(robot_);
  Command command = recall(Recall::stop);
  command.axes[0] = 1.0;
  for (int k = 0; k < second_; ++k)
    trip.step(command);
  EXPECT_EQ(trip.navigator().committed(), 0);
  EXPECT_FALSE(trip.navigator().refusal());
}

TEST_P(StopTest, WhatLedToTheStopLeadsBackFromIt) {
  for (int trial = 0; trial < 10; ++trial) {
    std::mt19937_64 random(200 + trial);
    Trip trip(robot_);
    const Posture home = trip.posture();
    for (int k = 0; k < 3; ++k) {
      const Command command = random_stick(random);
      for (int left = static_cast<int>(random() % static_cast<unsigned>(2.0 * second_)); left > 0; --left)
        trip.step(command);
      ticks_to_rest(trip, recall(Recall::stop));
    }
    for (int k = 0; k < 60 * second_ && (trip.navigator().history() > 0 || !rests(trip)); ++k)
      trip.step(recall(Recall::retrace));
    EXPECT_EQ(trip.navigator().history(), 0u);
    EXPECT_LT(distance(trip.posture(), home), 1e-4) << trial;
  }
}

TEST_P(StopTest, ALongWayBackThatIsLetGoOfRestsWithinAStepOrTwoAndGoesOnLater) {
  for (const double sideways : {0.0, 0.7}) {
    Trip trip(robot_);
    const Posture home = trip.posture();
    Command walk;
    walk.axes[0] = sideways == 0.0 ? 1.0 : 0.3;
    walk.axes[1] = sideways;
    for (int k = 0; k < 8 * second_; ++k)
      trip.step(walk);
    ticks_to_rest(trip, {});
    ASSERT_EQ(trip.navigator().history(), 1u);
    const double away = distance(trip.posture(), home);
    double left = away;
    int pauses = 0;
    for (int press = 0; press < 30 && trip.navigator().history() > 0; ++press) {
      VecX told = trip.step(recall(Recall::retrace)).q;
      for (int k = 1; k < second_; ++k) {
        const VecX next = trip.step(recall(Recall::retrace)).q;
        // It goes on from where it was told to be, to the bit.
        EXPECT_LT((trip.navigator().sample().q.tail(told.size()) - told).cwiseAbs().maxCoeff(), 1e-12);
        told = next;
      }
      EXPECT_LT(ticks_to_rest(trip, {}), 2.0 * second_);
      const double now = distance(trip.posture(), home);
      EXPECT_LT(now, left);
      left = now;
      ++pauses;
    }
    EXPECT_GE(pauses, 3);
    EXPECT_LT(left, 1e-4);
  }
}

}  // namespace
}  // namespace baton
