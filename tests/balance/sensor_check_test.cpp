// Readings that no robot can have are not believed; all others are, to the bit.
#include "baton/balance/sensor_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/proving/stick.hpp"
#include "baton/robot/glitches.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/glitches.hpp"
#include "tests/support/glitchy_robot.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using On = Simulation::On;

/// Motor torques are left out, as they are not used.
bool finite(const Measurement& m) {
  return m.q.allFinite() && m.dq.allFinite() && m.imu.attitude.allFinite() && m.imu.rate.allFinite() &&
         m.imu.acceleration.allFinite() && m.sole.left.force.allFinite() && m.sole.left.moment.allFinite() &&
         m.sole.right.force.allFinite() && m.sole.right.moment.allFinite();
}

bool equal(const Measurement& a, const Measurement& b) {
  return a.t == b.t && a.q == b.q && a.dq == b.dq && a.torque == b.torque && a.imu == b.imu && a.sole == b.sole;
}

bool all_good(const SensorCheck& sensors) {
  return std::all_of(kSensors.begin(), kSensors.end(),
                     [&](Sensor sensor) { return sensors.health(sensor) == Health::good; });
}

class SensorCheckTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const World flat_ = World::load("flat");
};
INSTANTIATE_TEST_SUITE_P(Robots, SensorCheckTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

/// What takes minutes of simulated time.
class SensorCheckRunsTest : public SensorCheckTest {};
INSTANTIATE_TEST_SUITE_P(Robots, SensorCheckRunsTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(SensorCheckRunsTest, WhatARobotInPhysicsMeasuresIsBelievedToTheBit) {
  for (const char* name : {"nominal", "noise", "push", "push_walk", "stiff_tiles"}) {
    const Scenario& scenario = scenario_named(name);
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      Simulation::Parameters parameters;
      parameters.physics.plant = plant_of(scenario, robot_, seed, 2.0);
      Simulation simulation(robot_, flat_, On::sim, parameters);
      const std::unique_ptr<Device> stick = stick_of(scenario, robot_, seed);
      SensorCheck sensors(robot_, StateSource::sensors);
      while (simulation.session().t() < 8.0 && !simulation.session().fallen()) {
        simulation.session().step(*stick);
        const Measurement m = simulation.simulated()->read();
        ASSERT_TRUE(equal(sensors.check(m, simulation.session().navigator().sample()), m))
            << name << ' ' << seed << " at " << m.t;
        ASSERT_TRUE(all_good(sensors));
      }
    }
  }
}

TEST_P(SensorCheckTest, NoGlitchPassesAndTheNextGoodReadingIsBelieved) {
  Simulation simulation(robot_, flat_, On::sim);
  Stick stick(5, robot_.profile().tick.period);
  std::mt19937_64 random(1);
  SensorCheck sensors(robot_, StateSource::sensors);
  const auto sample = [&]() -> const MotionSample& { return simulation.session().navigator().sample(); };
  for (int round = 0; round < 60; ++round) {
    for (const test::Glitch& glitch : test::glitches()) {
      const int ticks = std::uniform_int_distribution<int>(1, 6)(random);
      for (int k = 0; k < 10; ++k) {
        simulation.session().step(stick);
        const Measurement truth = simulation.simulated()->read();
        Measurement m = truth;
        if (k < ticks) glitch.spoil(m, random);
        const Measurement& believed = sensors.check(m, sample());
        ASSERT_TRUE(finite(believed)) << glitch.name;
        ASSERT_LT((believed.q - truth.q).cwiseAbs().maxCoeff(), 0.05) << glitch.name;
        ASSERT_LT(rotation_error(believed.imu.attitude, truth.imu.attitude).norm(), 0.05) << glitch.name;
      }
      ASSERT_TRUE(all_good(sensors)) << glitch.name;
    }
  }
}

TEST_P(SensorCheckTest, AnAngleThatNoJointCanHaveIsNeverBelieved) {
  Simulation simulation(robot_, flat_, On::sim);
  const auto joints = static_cast<Eigen::Index>(robot_.joints().size());
  std::mt19937_64 random(1);
  for (const double beyond : {0.31, 10.0, 1e100, 1e308}) {
    SensorCheck sensors(robot_, StateSource::sensors);
    const auto joint = std::uniform_int_distribution<Eigen::Index>(0, joints - 1)(random);
    const Range& range = robot_.joints()[static_cast<std::size_t>(joint)].position;
    const double angle = random() % 2 == 0 ? range.hi + beyond : range.lo - beyond;
    for (double t = 0.0; t < 1.0; t += robot_.profile().tick.period) {
      simulation.session().step(Command{});
      Measurement m = simulation.simulated()->read();
      const double truth = m.q[joint];
      if (t > 0.1) m.q[joint] = angle;
      ASSERT_NEAR(sensors.check(m, simulation.session().navigator().sample()).q[joint], truth, 0.01) << beyond;
    }
    EXPECT_EQ(sensors.health(Sensor::encoders), Health::lost);
  }
}

TEST_P(SensorCheckTest, ASensorThatIsGoneForLongIsLostAndThenBelievedAgain) {
  Simulation simulation(robot_, flat_, On::sim);
  std::mt19937_64 random(1);
  for (const test::Glitch& glitch : test::glitches()) {
    if (glitch.name.find("NaN") == std::string_view::npos || glitch.name.find("torque") != std::string_view::npos)
      continue;
    SensorCheck sensors(robot_, StateSource::sensors);
    const auto tick = [&](bool spoiled) {
      simulation.session().step(Command{});
      Measurement m = simulation.simulated()->read();
      std::mt19937_64 same(3);
      if (spoiled) glitch.spoil(m, same);
      static_cast<void>(sensors.check(m, simulation.session().navigator().sample()));
    };
    tick(false);
    const double period = robot_.profile().tick.period;
    for (double t = 0.0; t < 0.29; t += period) {
      tick(true);
      ASSERT_FALSE(sensors.lost()) << glitch.name;
    }
    for (double t = 0.0; t < 0.1; t += period)
      tick(true);
    EXPECT_TRUE(sensors.lost()) << glitch.name;
    for (double t = 0.0; t < 0.2; t += period)
      tick(false);
    EXPECT_TRUE(all_good(sensors)) << glitch.name;
  }
}

TEST_P(SensorCheckTest, AnImuThatRestartsWithAnotherYawIsBelievedAtItsOldYaw) {
  Simulation simulation(robot_, flat_, On::sim);
  SensorCheck sensors(robot_, StateSource::sensors);
  const Mat3 turn = rotation_z(1.0);
  for (int k = 0; k < 400; ++k) {
    simulation.session().step(Command{});
    Measurement m = simulation.simulated()->read();
    const Mat3 truth = m.imu.attitude;
    if (k >= 100) m.imu.attitude = turn * m.imu.attitude;
    const Measurement& believed = sensors.check(m, simulation.session().navigator().sample());
    ASSERT_LT(rotation_error(believed.imu.attitude, truth).norm(), 0.01) << k;
  }
  EXPECT_TRUE(all_good(sensors));
}

TEST_P(SensorCheckTest, AMeasurementThatComesAgainIsBridgedWhileThePlanMoves) {
  // Held for up to 0.3 s while the robot walks: what is believed goes on moving.
  Simulation simulation(robot_, flat_, On::sim);
  const std::unique_ptr<Device> stick = stick_of(scenario_named("push_walk"), robot_, 0);
  SensorCheck sensors(robot_, StateSource::sensors);
  Measurement held;
  for (int k = 0; k < 1200; ++k) {
    simulation.session().step(*stick);
    const Measurement truth = simulation.simulated()->read();
    const bool holds = k > 400 && k % 200 < 55;
    if (!holds) held = truth;
    const Measurement& believed = sensors.check(held, simulation.session().navigator().sample());
    ASSERT_LT((believed.q - truth.q).cwiseAbs().maxCoeff(), 0.03) << k;
    ASSERT_LT(rotation_error(believed.imu.attitude, truth.imu.attitude).norm(), 0.01) << k;
    ASSERT_LT((believed.imu.acceleration - truth.imu.acceleration).norm(), 2.0) << k;
    for (const Side side : kSides) {
      if (!holds) continue;
      ASSERT_LT(std::abs((believed.sole[side].force - truth.sole[side].force).z()), 0.9 * robot_.mass() * kGravity)
          << k;
    }
    ASSERT_FALSE(sensors.lost());
  }
}

TEST_P(SensorCheckTest, ForcesOfTheWrongFootAreToldFromTheMotorTorques) {
  Simulation simulation(robot_, flat_, On::sim);
  const std::unique_ptr<Device> stick = stick_of(scenario_named("push_walk"), robot_, 0);
  SensorCheck sensors(robot_, StateSource::sensors);
  long exchanged = 0;
  long rejected = 0;
  for (int k = 0; k < 2000; ++k) {
    simulation.session().step(*stick);
    Measurement m = simulation.simulated()->read();
    const Navigator& navigator = simulation.session().navigator();
    const bool on_one_foot = navigator.sample().contact.left != navigator.sample().contact.right;
    const bool swap = on_one_foot && k % 100 < 20;
    if (swap) std::swap(m.sole.left, m.sole.right);
    static_cast<void>(sensors.check(m, navigator.sample()));
    exchanged += swap ? 1 : 0;
    rejected += swap && sensors.health(Sensor::forces) != Health::good ? 1 : 0;
  }
  EXPECT_GT(exchanged, 100);
  EXPECT_GT(rejected, 0.8 * exchanged);
}

/// Faults of every kind, one every 0.4 to 2 s, for up to 0.3 s.
void drive_with_glitches(const RobotModel& robot, const World& world, const std::string& scenario, std::uint64_t seed,
                         double seconds) {
  Simulation simulation(robot, world, On::sim);
  test::GlitchyRobot glitchy(*simulation.simulated());
  Session session(robot, world, glitchy, stand(robot, world.site("start"), robot.profile().stance.com_height));
  const std::unique_ptr<Device> stick = stick_of(scenario_named(scenario), robot, seed);
  Glitches glitches(2.0, robot.profile().tick.period, seed);
  glitchy.spoil = [&](Measurement& m) { glitches.spoil(m); };
  long rejected = 0;
  while (session.t() < seconds) {
    session.step(*stick);
    rejected += all_good(session.navigator().sensors()) ? 0 : 1;
    ASSERT_FALSE(session.fallen()) << session.truth()->fall << " at " << session.t() << " s, after "
                                   << to_string(glitches.fault()) << ' ' << to_string(glitches.reading());
    ASSERT_EQ(session.navigator().guard(), Guard::armed)
        << to_string(glitches.fault()) << ' ' << to_string(glitches.reading());
  }
  EXPECT_GT(rejected, 0);
  EXPECT_TRUE(scenario == "push_stand" || session.navigator().committed() > 0.2 * seconds);
}

TEST_P(SensorCheckRunsTest, GlitchesNeitherTipARobotThatStandsNorOneThatWalks) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    for (const char* scenario : {"push_stand", "push_walk", "nominal"}) {
      drive_with_glitches(robot_, flat_, scenario, seed, 12.0);
      if (HasFatalFailure()) return;
    }
  }
}

TEST_P(SensorCheckRunsTest, AccelerometersWithTwoAxesExchangedMakeNoWalkingRobotFall) {
  const double second = std::sqrt(robot_.profile().stance.com_height / 0.26);
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Simulation::Parameters parameters;
    parameters.physics.plant = real_plant(robot_, seed);
    Simulation simulation(robot_, flat_, On::sim, parameters);
    test::GlitchyRobot glitchy(*simulation.simulated());
    Session session(robot_, flat_, glitchy, stand(robot_, flat_.site("start"), robot_.profile().stance.com_height));
    Command ahead;
    ahead.axes[0] = 1.0;
    std::mt19937_64 random(seed);
    double from = second;
    while (session.t() < 15.0 * second && !session.fallen()) {
      if (session.t() > from + 0.17 * second)
        from = session.t() + second * std::uniform_real_distribution<double>(0.6, 1.5)(random);
      const bool wrong = session.t() >= from;
      glitchy.spoil = [&](Measurement& m) {
        if (wrong) std::swap(m.imu.acceleration.x(), m.imu.acceleration.z());
      };
      session.step(ahead);
    }
    EXPECT_FALSE(session.fallen()) << "seed " << seed << " at " << session.t() << " s";
    EXPECT_GT(session.navigator().committed(), 10);
  }
}

TEST(SensorCheck, ARobotThatReturnsVectorsOfAnotherLengthIsNamed) {
  const RobotModel& robot = test::robot("mighty");
  const World flat = World::load("flat");
  Simulation simulation(robot, flat, On::sim);
  test::GlitchyRobot odd(*simulation.simulated());
  Session session(robot, flat, odd, stand(robot, flat.site("start"), robot.profile().stance.com_height));
  odd.spoil = [](Measurement& m) { m.q.conservativeResize(m.q.size() - 1); };
  try {
    session.step(Command{});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("19 joint angles (q); must be 20"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace baton
