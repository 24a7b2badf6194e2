#include "baton/proving/episode.hpp"

#include <gtest/gtest.h>

#include "baton/ik/stand.hpp"
#include "baton/proving/judges.hpp"
#include "tests/proving/trial.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::trial;

/// A short episode with little room, at a kind of place where something was found before, or would be.
struct Situation {
  const char* name;
  std::uint64_t seed;
  long episode;
  const char* robot = "mighty";
  Simulation::On on = Simulation::On::ideal;
  Modes modes = {};
};

class EpisodeInClutter : public testing::TestWithParam<Situation> {};

INSTANTIATE_TEST_SUITE_P(Situations, EpisodeInClutter,
                         testing::Values(Situation{"TallAndLeaning", 1, 54}, Situation{"AFootUpOverUnevenGround", 1, 9},
                                         Situation{"AHandAtAnObstacle", 1, 47}, Situation{"ASwingAtAnEdge", 1, 173},
                                         Situation{"TheShortestDurationOrNothing",
                                                   1,
                                                   24,
                                                   "mighty",
                                                   Simulation::On::ideal,
                                                   {DurationRule::search, OnLimit::discard}},
                                         Situation{"ALargerRobot", 1, 6, "scaled"},
                                         Situation{"AFootThatSlippedAtAnEdge", 1, 27, "mighty", Simulation::On::sim}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(EpisodeInClutter, NothingGoesWrong) {
  const Situation& s = GetParam();
  const World clutter(std::string(BATON_SOURCE_DIR) + "/tests/worlds/clutter.xml");
  const Episodes episodes(test::robot(s.robot), clutter,
                          trial(s.on, s.seed, s.on == Simulation::On::sim ? 8.0 : 10.0, s.modes));
  const std::atomic<bool> stop{false};
  const Tally tally = episodes.run(s.episode, stop).tally;
  for (const Tally::Failure& failure : tally.listed) {
    ADD_FAILURE() << failure.kind << " at " << failure.t << " s: " << failure.value << ", limit " << failure.limit
                  << " " << failure.where;
  }
  EXPECT_EQ(tally.failures, 0);
  EXPECT_GE(tally.segments, 5);
  EXPECT_GE(tally.retrace.tried, 1);
  if (s.on == Simulation::On::ideal) {
    EXPECT_EQ(tally.retrace.arrived, tally.retrace.tried);
  }
}

/// Servos that are far stiffer than their lag bears shake so that the robot balances and begins nothing any more, on
/// some plants.
TEST(Episode, EndsWhenARobotDoesNotBeginToRetrace) {
  Profile profile = test::robot("mighty").profile();
  profile.drive = Drive::stiff;
  for (auto& [name, gains] : profile.gains)
    gains.kp *= 80.0;
  const RobotModel robot(std::move(profile));
  const World flat = World::load("flat");
  const std::atomic<bool> stop{false};
  Trial shaking = trial(Simulation::On::sim, 2, 6.0);
  shaking.real = true;
  Tally tally;
  for (long episode = 0; episode < 8 && !tally.bad.contains("frozen"); ++episode)
    tally = Episodes(robot, flat, shaking).run(episode, stop).tally;
  ASSERT_EQ(tally.bad, (std::map<std::string, long>{{"frozen", 1}}));
  EXPECT_LT(tally.listed.front().t, 200.0);
}

TEST(Episode, KnowsWhenNothingGoesAnyMore) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  Strategy strategy(robot, world, {DurationRule::paper, OnLimit::discard});
  Request request;
  GuideContext& context = request.start.context;
  context.from = stand(robot, world.site("start"), robot.profile().stance.com_height);
  context.foothold = context.from.sole;
  request.start.posture = context.from;
  EXPECT_FALSE(stuck(strategy, request));
  const int elbow = robot.arm(Side::left).back();
  context.from.q[7 + elbow] = robot.joints()[static_cast<std::size_t>(elbow)].position.hi + 0.1;
  request.start.posture = context.from;
  EXPECT_TRUE(stuck(strategy, request));
}

}  // namespace
}  // namespace baton
