#include "bench/latency.hpp"

#include <gtest/gtest.h>

#include "tests/support/robots.hpp"

namespace baton::bench {
namespace {

TEST(Latency, IsTheSameForTheSameSeedAndNeverBelowTheLookahead) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  const double lookahead = robot.profile().tick.lookahead * robot.profile().tick.period;
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Change change = change_of_command(robot, world, seed);
    const Change again = change_of_command(robot, world, seed);
    EXPECT_EQ(change.situation, again.situation);
    EXPECT_EQ(change.switched, again.switched);
    EXPECT_EQ(change.latency, again.latency);
    EXPECT_EQ(change.first_against, again.first_against);
    EXPECT_EQ(change.plan_us.size(), again.plan_us.size());
    if (!change.latency) continue;
    ++moved;
    EXPECT_GE(*change.latency, lookahead - 1e-9);
    EXPECT_FALSE(change.plan_us.empty());
  }
  EXPECT_GT(moved, 0);
}

}  // namespace
}  // namespace baton::bench
