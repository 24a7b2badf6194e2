/// When the operator is told that a part is stuck, and what is said to lead out.
#include "app/refusals.hpp"

#include <gtest/gtest.h>

#include "baton/ik/stand.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

class RefusalsTest : public testing::Test {
 protected:
  /// Holds the stick for so long [s], and lets go of it.
  void hold(const Command& command, double time = 0.3) {
    for (double t = 0.0; t < time; t += period_)
      step(command);
    for (double t = 0.0; t < time || navigator_.motion() != nullptr; t += period_)
      step({.guide = command.guide});
  }

  /// Onto the other foot: refused.
  static Command inward(Side side, double far = 1.0) {
    Command command{.guide = side == Side::left ? Part::left_foot : Part::right_foot};
    command.axes[1] = side == Side::left ? -far : far;
    return command;
  }
  static Command walk() {
    Command command;
    command.axes[0] = 1.0;
    return command;
  }

  app::Refusals refusals_;
  bool refuses_ways_back_ = false;

 private:
  void step(const Command& command) {
    body_.write(navigator_.tick(body_.read(), command));
    if (const std::optional<Request> request = navigator_.request()) {
      Answer result = strategy_.plan(*request);
      if (refuses_ways_back_ && request->command.recall != Recall::none)
        result.outcome = Refusal{Reason::self_collision, Part::left_hand, 0.001, 0.002, "arm and trunk"};
      navigator_.answer(std::move(result));
    }
    refusals_.look(navigator_);
  }

  const RobotModel& robot_ = test::robot("mighty");
  const World world_ = World::load("flat");
  const double period_ = robot_.profile().tick.period;
  const Posture start_ = stand(robot_, world_.site("start"), robot_.profile().stance.com_height);
  const Modes modes_{.on_limit = OnLimit::discard, .gait = Gait::stop};
  IdealRobot body_{robot_, start_, period_};
  Navigator navigator_{robot_, world_, start_, modes_.gait};
  Strategy strategy_{robot_, world_, modes_};
};

TEST_F(RefusalsTest, APartThatIsRefusedThreeTimesInARowIsStuckUntilAnythingMoves) {
  hold(inward(Side::left));
  hold(inward(Side::left, 0.9));
  EXPECT_FALSE(refusals_.stuck());
  hold(inward(Side::left));
  ASSERT_TRUE(refusals_.stuck());
  EXPECT_EQ(refusals_.stuck()->part, Part::left_foot);
  EXPECT_EQ(refusals_.stuck()->times, 3);
  EXPECT_FALSE(refusals_.stuck()->retrace) << "there is nothing to retrace";
  EXPECT_TRUE(refusals_.stuck()->home);
  hold(walk());
  EXPECT_FALSE(refusals_.stuck());
  EXPECT_EQ(refusals_.count(), 3);
  EXPECT_EQ(refusals_.newest()->reason, Reason::foot_region);
}

TEST_F(RefusalsTest, ThreeRefusalsOfDifferentPartsAreNotOfOne) {
  for (int i = 0; i < 3; ++i) {
    hold(inward(Side::left));
    hold(inward(Side::right));
  }
  EXPECT_FALSE(refusals_.stuck());
  EXPECT_EQ(refusals_.count(), 6);
}

TEST_F(RefusalsTest, AWayBackThatWasRefusedIsNoAdviceUntilSomethingMoved) {
  hold(walk());
  refuses_ways_back_ = true;
  for (int i = 0; i < 3; ++i)
    hold(inward(Side::left));
  ASSERT_TRUE(refusals_.stuck());
  EXPECT_TRUE(refusals_.stuck()->retrace);
  hold({.recall = Recall::retrace});
  ASSERT_TRUE(refusals_.stuck()) << "it is the foot that is stuck, still";
  EXPECT_EQ(refusals_.stuck()->times, 3);
  EXPECT_FALSE(refusals_.stuck()->retrace);
  EXPECT_TRUE(refusals_.stuck()->home);
  hold({.recall = Recall::home});
  EXPECT_FALSE(refusals_.stuck()->home);
  hold(walk());
  for (int i = 0; i < 3; ++i)
    hold(inward(Side::left));
  EXPECT_TRUE(refusals_.stuck()->retrace);
  EXPECT_TRUE(refusals_.stuck()->home);
}

TEST_F(RefusalsTest, AWayBackThatIsRefusedAgainAndAgainIsNoStuckPart) {
  refuses_ways_back_ = true;
  for (int i = 0; i < 5; ++i)
    hold({.recall = Recall::retrace});
  EXPECT_EQ(refusals_.count(), 5);
  EXPECT_FALSE(refusals_.stuck());
}

}  // namespace
}  // namespace baton
