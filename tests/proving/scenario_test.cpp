// Physics that is not the model.
#include "baton/proving/scenario.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <set>

#include "baton/model/error.hpp"
#include "baton/proving/episode.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

bool is_the_model(const Plant& p) {
  return !p.friction && !p.solref && p.mass == 1.0 && p.com_offset.isZero(0.0) && p.actuators.gain == 1.0 &&
         p.actuators.strength == 1.0 && p.actuators.kp == 1.0 && p.actuators.delay == 0.0 &&
         p.sensors.glitches == 0.0 && p.sensors.encoder_noise == 0.0 && p.sensors.force_noise == 0.0 &&
         p.sensors.imu_bias.isZero(0.0) && p.tilt.isZero(0.0) && p.tiles == 0.0 && p.pushes.empty();
}

TEST(Scenario, EachIsSomethingElseThanTheModelAndTheSameForTheSameSeed) {
  const RobotModel& robot = test::robot("mighty");
  std::set<std::string_view> names;
  for (const Scenario& scenario : scenarios()) {
    EXPECT_TRUE(names.insert(scenario.name).second);
    EXPECT_FALSE(scenario.what.empty());
    EXPECT_EQ(&scenario_named(std::string(scenario.name)), &scenario);
    const bool model = scenario.name == "nominal" || scenario.name == "stiff";
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const Plant a = plant_of(scenario, robot, seed);
      const Plant b = plant_of(scenario, robot, seed);
      EXPECT_EQ(is_the_model(a), model) << scenario.name;
      EXPECT_EQ(a.seed, b.seed);
      EXPECT_EQ(a.com_offset, b.com_offset);
      EXPECT_EQ(a.tilt, b.tilt);
      ASSERT_EQ(a.pushes.size(), b.pushes.size());
      for (std::size_t i = 0; i < a.pushes.size(); ++i)
        EXPECT_EQ(a.pushes[i].impulse, b.pushes[i].impulse);
    }
  }
  EXPECT_THROW(static_cast<void>(scenario_named("earthquake")), InputError);
}

TEST(Scenario, HasTheSizeThatItSays) {
  const RobotModel& robot = test::robot("mighty");
  for (std::uint64_t seed = 0; seed < 160; ++seed) {
    const auto plant = [&](const char* name, double times = 1.0) {
      return plant_of(scenario_named(name), robot, seed, times);
    };
    EXPECT_NEAR(plant("com").com_offset.norm(), 0.010, 1e-9);
    EXPECT_NEAR(plant("slope").tilt.norm(), 3.0 * M_PI / 180.0, 1e-12);
    EXPECT_NEAR(plant("slope", 0.5).tilt.norm(), 1.5 * M_PI / 180.0, 1e-12);
    EXPECT_NEAR(plant("push_side").pushes.at(0).impulse.norm(), 1.2, 2e-3);
    EXPECT_NEAR(plant("push_walk").pushes.at(0).impulse.norm(), 0.6, 1e-3);
    EXPECT_NEAR(plant("push_side").pushes.at(0).impulse.x(), 0.0, 1e-9);
    EXPECT_NEAR(plant("push_fore").pushes.at(0).impulse.y(), 0.0, 1e-9);
    EXPECT_GE(*plant("contact").solref, 0.002 - 1e-12);
    EXPECT_LE(*plant("contact").solref, 0.040 + 1e-12);
  }
}

TEST(Scenario, SinglePushesComeFromEightDirectionsAtTwentyInstants) {
  const RobotModel& robot = test::robot("mighty");
  std::set<std::pair<long, long>> seen;
  for (std::uint64_t seed = 0; seed < 160; ++seed) {
    const Push push = plant_of(scenario_named("push_walk"), robot, seed).pushes.at(0);
    const double angle = std::atan2(push.impulse.y(), push.impulse.x());
    seen.insert({std::lround(4.0 * angle / M_PI) & 7, std::lround(push.t / 0.05)});
  }
  EXPECT_EQ(seen.size(), 160u);
}

/// Each of them, for a few seconds: what was seen to stay on its feet for hours does so here as well.
TEST(Scenario, MightyStaysOnItsFeet) {
  const World flat = World::load("flat");
  const std::atomic<bool> stop{false};
  for (const Scenario& scenario : scenarios()) {
    RobotModel robot = RobotModel::load("mighty");
    const Drive drive = drive_of(scenario, robot);
    if (drive != robot.profile().drive) robot = with_drive(robot, drive);
    Trial trial;
    trial.on = Simulation::On::sim;
    trial.seed = 4;
    trial.seconds = 4.0;
    trial.scenario = &scenario;
    const EpisodeResult result = Episodes(robot, flat, trial).run(0, stop);
    EXPECT_EQ(result.summary["falls"], 0) << scenario.name;
    EXPECT_LT(result.summary["tilt_deg_max"].get<double>(), 25.0) << scenario.name;
    if (scenario.driving != Driving::stand) {
      EXPECT_GE(result.tally.segments, 2) << scenario.name;
    }
  }
}

TEST(Scenario, AStepCatchesMightyFromAPushThatStandingCannotHold) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  for (const long seed : {0, 1}) {  // fore and aft
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant_of(scenario_named("push_fore"), robot, static_cast<std::uint64_t>(seed), 1.6);
    Simulation simulation(robot, world, Simulation::On::sim, {.physics = parameters});
    Session& session = simulation.session();
    const double before = session.truth()->q[0];
    double farthest = 0.0;
    while (session.t() < 6.0 && !session.fallen()) {
      session.step({});
      farthest = std::max(farthest, (session.truth()->q[0] - before) * (seed == 0 ? 1.0 : -1.0));
    }
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
    EXPECT_GE(session.navigator().caught(), 1);
    EXPECT_TRUE(session.resting());
    EXPECT_EQ(session.navigator().guard(), Guard::armed);
    EXPECT_GT(farthest, robot.profile().margin.stand_on) << "no push that standing can hold";
  }
}

TEST(Scenario, AFootThatIsHeldUpComesDownWhereItCatchesMighty) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  for (const double ahead : {1.6, -1.6}) {
    SimulatedRobot::Parameters parameters;
    parameters.plant.pushes = {{4.0, 0.05, Vec3(ahead, 0, 0)}};
    Simulation simulation(robot, world, Simulation::On::sim, {.physics = parameters});
    Session& session = simulation.session();
    Command command;
    command.guide = Part::left_foot;
    command.lift.left = 0.5;
    while (session.t() < 4.0)
      session.step(command);
    ASSERT_TRUE(session.resting());
    ASSERT_FALSE(session.navigator().sample().contact.left);
    while (session.t() < 8.0 && !session.fallen())
      session.step(command);
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
    EXPECT_GE(session.navigator().caught(), 1);
  }
}

}  // namespace
}  // namespace baton
