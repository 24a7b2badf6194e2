/// The navigator as a state machine: whatever the stick, the planner's answers and the robot do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/navigate/fuzzed_run.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::FuzzedRun;

/// Seeds to try; more of them on a night that is long: BATON_FUZZ_RUNS=500.
int runs() {
  const char* more = std::getenv("BATON_FUZZ_RUNS");
  return more == nullptr ? 16 : std::max(16, std::atoi(more));
}

class FuzzTest : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Robots, FuzzTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(FuzzTest, EveryTickIsVerifiedOrHeldOrSoftItStopsOnBothFeetAndReplays) {
  const RobotModel& robot = test::robot(GetParam());
  const World flat = World::load("flat");
  const World room = World::load("room");
  const int count = runs();
  FuzzedRun::Tally sum;
  int armed = 0;  // when a stop was held
  for (int seed = 1; seed <= count; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    FuzzedRun run(robot, seed % 3 == 0 ? room : flat, static_cast<std::uint64_t>(seed));
    run.drive(10.0);
    if (HasFatalFailure()) return;
    if (seed % 2 == 0) run.calm_down();
    Command stop;
    stop.recall = Recall::stop;
    run.hold(stop, 10.0);
    if (HasFatalFailure()) return;
    if (run.navigator().guard() == Guard::armed) {
      ++armed;
      EXPECT_TRUE(run.rests_on_both_feet()) << "after stop was held";
    }
    run.calm_down();
    EXPECT_EQ(run.navigator().guard(), Guard::armed);
    // And it can be driven on.
    const long before = run.navigator().committed();
    // Not everywhere: arms that were driven may be next to a thigh.
    for (const auto& [axis, way] : {std::pair(2, 1.0), {2, -1.0}, {1, 1.0}, {1, -1.0}, {0, 1.0}}) {
      if (run.navigator().committed() > before) break;
      Command move;
      move.axes[axis] = way;
      run.hold(move, 0.5);
    }
    // Only here can it be stood up with one foot inside the other.
    Kinematics kinematics(robot);
    kinematics.set(run.navigator().sample().q);
    EXPECT_TRUE(run.navigator().committed() > before || kinematics.self_distance(0.0) < 0.0);
    run.replay();
    if (HasFatalFailure()) return;
    sum += run.tally();
  }
  // All of it was tried.
  EXPECT_GT(sum.ordinary, 10 * count);
  EXPECT_GT(sum.stops, count / 8);
  EXPECT_GT(sum.catches, count / 4);
  EXPECT_GT(sum.refused, count);
  EXPECT_GT(sum.disturbed, 20 * count);
  EXPECT_GT(sum.slips, count / 2);
  EXPECT_GT(sum.lifts, count / 8);
  EXPECT_GT(sum.falls, count / 4);
  EXPECT_GT(sum.stood_up, 0);
  EXPECT_GT(armed, count / 3);
}

}  // namespace
}  // namespace baton
