#include "baton/proving/link_trial.hpp"

#include <gmock/gmock.h>

#include "tests/support/robots.hpp"

namespace baton {
namespace {

class LinkTrialTest : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Robots, LinkTrialTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(LinkTrialTest, WhateverHappensToTheConnectionTheRobotStandsAndComesToRest) {
  const RobotModel& robot = test::robot(GetParam());
  const World world = World::load("flat");
  std::array<long, kLinkFaults.size()> faults{};
  std::string log;
  long motions = 0;
  long drivers = 0;
  long stale = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const LinkTrialResult result = run_link_trial(robot, world, {seed, {}, 6.0});
    EXPECT_EQ(result.fall, "") << "seed " << seed;
    EXPECT_TRUE(result.rests) << "seed " << seed;
    motions += result.motions;
    drivers += result.drivers;
    stale += result.stale;
    for (std::size_t kind = 0; kind < faults.size(); ++kind)
      faults[kind] += result.faults[kind];
    for (const std::string& line : result.log)
      log += line + '\n';
  }
  EXPECT_GT(motions, 60);
  EXPECT_GT(drivers, 12);
  EXPECT_GT(stale, 100);
  for (std::size_t kind = 0; kind < faults.size(); ++kind)
    EXPECT_GT(faults[kind], 0) << kLinkFaults[kind];
  for (const char* said : {"driver lost", "refused (protocol)", "link: the stick's positions are more than 0.5 s old",
                           "link: the stick counts again", "too slow for real time"})
    EXPECT_THAT(log, testing::HasSubstr(said));
}

// At the instant at which a trial ends otherwise, its motors are hot, and it stands straighter by itself.
TEST(LinkTrial, ARobotThatCoolsDownHasComeToRest) {
  const LinkTrialResult result = run_link_trial(test::robot("mighty"), World::load("flat"), {300223, {}, 10.0});
  EXPECT_EQ(result.fall, "");
  EXPECT_TRUE(result.rests);
}

TEST_P(LinkTrialTest, ItIsAFunctionOfItsSeed) {
  const RobotModel& robot = test::robot(GetParam());
  const World world = World::load("flat");
  const LinkTrialResult once = run_link_trial(robot, world, {3, {}, 4.0});
  const LinkTrialResult again = run_link_trial(robot, world, {3, {}, 4.0});
  EXPECT_EQ(once.motions, again.motions);
  EXPECT_EQ(once.stale, again.stale);
  EXPECT_EQ(once.faults, again.faults);
  EXPECT_EQ(once.log, again.log);
}

}  // namespace
}  // namespace baton
