#include "baton/shadow/shadow.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "baton/model/error.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton::shadow {
namespace {

using testing::AnyOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Command still(double /*t*/) {
  return {};
}
Command walking(double t) {
  Command command;
  if (t > 1.5 && t < 3.5) command.axes[0] = 1.0;
  return command;
}

class ShadowTest : public testing::TestWithParam<std::string> {
 protected:
  /// Changes what the shadow gets; false: it gets nothing.
  using Spoil = std::function<bool(link::Reading&)>;
  using Stick = std::function<Command(double t)>;

  const RobotModel& robot_ = test::robot(GetParam());
  const double period_ = robot_.profile().tick.period;
  const World world_ = World::load("flat");

  /// Looks on at a simulated robot that baton drives.
  /// @param ask what the shadow's stick does
  [[nodiscard]] std::unique_ptr<Shadow> watch(
      const Plant& plant, double seconds, const Stick& drive = still, const Stick& ask = still,
      const Spoil& spoil = [](link::Reading&) { return true; }) const {
    auto shadow = std::make_unique<Shadow>(robot_, world_, Shadow::Parameters{});
    Simulation::Parameters parameters;
    parameters.physics.plant = plant;
    Simulation simulation(robot_, world_, Simulation::On::sim, parameters);
    Session& session = simulation.session();
    std::uint64_t sequence = 0;
    while (session.t() < seconds) {
      link::Reading reading;
      reading.sequence = sequence++;
      reading.measurement = simulation.simulated()->read();
      if (spoil(reading)) shadow->tick(reading, session.truth(), ask(session.t()));
      session.step(drive(session.t()));
    }
    return shadow;
  }
  [[nodiscard]] Plant plant(const char* scenario, std::uint64_t seed, double times = 1.0) const {
    return plant_of(false, &scenario_named(scenario), robot_, seed, times);
  }
  static std::vector<std::string> found(const Shadow& shadow) {
    std::vector<std::string> whats;
    for (const Finding& finding : shadow.findings())
      whats.push_back(finding.what);
    return whats;
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, ShadowTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(ShadowTest, ARobotThatIsAsTheModelSaysIsInOrder) {
  const auto shadow = watch({}, 6.0, walking);
  EXPECT_THAT(found(*shadow), IsEmpty()) << shadow->summary();
  EXPECT_GT(shadow->standing().seconds(), 1.5);
  EXPECT_TRUE(shadow->still());
  EXPECT_EQ(shadow->timing().begun, 1);
  EXPECT_NEAR(shadow->timing().interval.mean(), period_, 1e-9);
  for (const Comparison& one : shadow->standing().all()) {
    EXPECT_GT(one.value.n, 100) << one.what;
    EXPECT_LT(std::abs(one.value.mean()), 0.2 * one.limit) << one.what;
  }
}

TEST_P(ShadowTest, WhatIsWrongIsNamed) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    EXPECT_THAT(found(*watch(plant("mass", seed), 2.0)), Contains("weight by the sole forces"));
    EXPECT_THAT(found(*watch(plant("payload", seed), 2.0)),
                Contains(AnyOf(HasSubstr("COM to the left"), HasSubstr("COM ahead"))));
    const auto tilted = AnyOf("IMU's roll against the soles", "IMU's pitch against the soles");
    const auto turned = AnyOf(HasSubstr("right sole's"), HasSubstr("IMU's"));
    const std::vector<std::string> askew = found(*watch(plant("mount", seed, 2.0), 2.0));
    EXPECT_THAT(askew, Contains(tilted));
    EXPECT_THAT(askew, Not(Contains(HasSubstr("right sole's"))));
    EXPECT_THAT(found(*watch(plant("encoders", seed, 3.0), 3.0)), Contains(turned));
    EXPECT_THAT(found(*watch(plant("yaw_drift", seed), 7.0)), Contains("yaw drift"));
  }
}

TEST_P(ShadowTest, EachNumberIsWhatWasDoneToTheRobot) {
  const auto mean = [](const Shadow& shadow, const std::string& what) {
    for (const Comparison& one : shadow.standing().all()) {
      if (one.what == what) return one.value.mean();
    }
    ADD_FAILURE() << what;
    return kNan;
  };
  const double weight = robot_.mass() * kGravity;
  EXPECT_NEAR(mean(*watch(plant("mass", 0), 2.0), "weight by the sole forces"), 0.1 * weight, 1e-3 * weight);
  EXPECT_NEAR(mean(*watch(plant("mass", 1), 2.0), "weight by the motor torques"), -0.1 * weight, 0.05 * weight);
  const auto askew = watch(plant("mount", 5), 2.0);
  const double tilt =
      std::hypot(mean(*askew, "IMU's roll against the soles"), mean(*askew, "IMU's pitch against the soles"));
  EXPECT_NEAR(tilt, M_PI / 180.0, 0.1 * M_PI / 180.0);
  const auto drifts = watch(plant("yaw_drift", 2), 7.0);
  EXPECT_NEAR(std::abs(drifts->standing().yaw_drift()), 10.0 / 60.0 * M_PI / 180.0, 0.1 / 60.0 * M_PI / 180.0);
  // A torque sensor that is off.
  const std::size_t j = 4;
  const double off = 0.2 * robot_.joints()[j].motor.stall;
  const auto shadow = watch({}, 2.0, still, still, [&](link::Reading& reading) {
    reading.measurement.torque[j] += off;
    return true;
  });
  EXPECT_NEAR(mean(*shadow, "torque of " + robot_.joints()[j].name), off, 0.02 * off);
  EXPECT_THAT(found(*shadow), Contains("torque of " + robot_.joints()[j].name));
}

TEST_P(ShadowTest, HowMeasurementsComeIsCounted) {
  std::mt19937_64 random(3);
  long lost = 0, late = 0;
  const auto shadow = watch({}, 3.0, still, still, [&](link::Reading& reading) {
    const std::uint64_t k = reading.sequence;
    if (k % 10 == 5) reading.measurement.age = 6.0 * period_;
    late += k % 10 == 5 ? 1 : 0;
    if (k == 0 || random() % 20 != 0) return true;
    ++lost;
    late -= k % 10 == 5 ? 1 : 0;
    return false;
  });
  EXPECT_NEAR(static_cast<double>(shadow->timing().lost), static_cast<double>(lost), 1.0);  // the last may be missing
  EXPECT_EQ(shadow->timing().late, late);
  EXPECT_THAT(found(*shadow), Contains("lost"));
  EXPECT_THAT(found(*shadow), Contains("late"));

  Timing timing(period_);
  link::Reading reading;
  const auto take = [&](std::uint64_t sequence, double t) {
    reading.sequence = sequence;
    reading.measurement.t = t;
    return timing.take(reading);
  };
  EXPECT_EQ(take(6, kNan), Timing::Kind::repeated);
  EXPECT_EQ(take(7, 1.0), Timing::Kind::anew);
  EXPECT_EQ(take(8, 1.0 + period_), Timing::Kind::next);
  EXPECT_EQ(take(8, 1.0 + period_), Timing::Kind::out_of_order);
  EXPECT_EQ(take(9, 1.0 + period_), Timing::Kind::repeated);
  EXPECT_EQ(take(12, 1.0 + 4 * period_), Timing::Kind::next);
  EXPECT_EQ(take(11, 1.0 + 3 * period_), Timing::Kind::out_of_order);
  EXPECT_EQ(take(13, 0.0), Timing::Kind::anew);  // its clock was set back
  EXPECT_EQ(take(14, 9.0), Timing::Kind::anew);
  EXPECT_EQ(timing.lost, 2);
  EXPECT_EQ(timing.repeated, 2);
  EXPECT_EQ(timing.out_of_order, 2);
  EXPECT_EQ(timing.begun, 3);
  EXPECT_NEAR(timing.seconds(), 4 * period_, 1e-12);
}

TEST_P(ShadowTest, SensorsThatAreNotBelievedAndJointsBeyondTheirRangeAreNamed) {
  const std::size_t j = 2;
  const Joint& joint = robot_.joints()[j];
  const auto shadow = watch({}, 3.0, walking, still, [&](link::Reading& reading) {
    Measurement& m = reading.measurement;
    if (reading.sequence >= 100 && reading.sequence < 110) m.imu.rate.setConstant(kNan);
    if (reading.sequence == 200) m.q[j] = joint.position.hi + 0.25;
    if (reading.sequence == 300) m.torque[j] = -1.2 * joint.motor.stall;
    return true;
  });
  EXPECT_THAT(found(*shadow), Contains("gyro"));
  const nlohmann::json gyro = shadow->json()["sensors"]["gyro"];
  EXPECT_EQ(gyro["not_finite"], 10);
  EXPECT_EQ(gyro["times"], 1);
  EXPECT_NEAR(gyro["first_t"].get<double>(), 100 * period_, 1e-9);
  EXPECT_THAT(found(*shadow), Contains("angle of " + joint.name));
  EXPECT_THAT(found(*shadow), Contains("torque of " + joint.name));
  EXPECT_THAT(found(*shadow), Contains("encoders"));
}

TEST_P(ShadowTest, NothingThatIsMeasuredBreaksIt) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int run = 0; run < 4; ++run) {
    const auto shadow = watch({}, 2.0, walking, walking, [&](link::Reading& reading) {
      Measurement& m = reading.measurement;
      if (random() % 4 != 0) return true;
      const double strange = random() % 2 == 0 ? kNan : any(random) * std::pow(10.0, 20.0 * any(random));
      switch (random() % 9) {
        case 0:
          m.q[static_cast<Eigen::Index>(random() % m.q.size())] = strange;
          break;
        case 1:
          m.dq.setConstant(strange);
          break;
        case 2:
          m.torque.setConstant(strange);
          break;
        case 3:
          m.imu.attitude(1, 2) = strange;
          break;
        case 4:
          m.imu.rate.setConstant(strange);
          break;
        case 5:
          m.imu.acceleration.setConstant(strange);
          break;
        case 6:
          m.sole.left.force.setConstant(strange);
          break;
        case 7:
          m.t = strange;
          break;
        default:
          m.age = strange;
      }
      return true;
    });
    EXPECT_FALSE(shadow->findings().empty());
    EXPECT_FALSE(shadow->summary().empty());
    EXPECT_NO_THROW((void)shadow->json().dump());
  }
}

TEST_P(ShadowTest, AFallIsJudgedOneByTheGuardAndTheSimulatorAlike) {
  Plant pushed;
  const double speed = std::sqrt(kGravity * robot_.profile().stance.com_height);
  pushed.pushes.push_back({1.0, 0.05, Vec3(0.0, 1.5 * robot_.mass() * speed, 0.0)});
  const auto shadow = watch(pushed, 4.0);
  EXPECT_THAT(found(*shadow), Contains("guard: fallen"));
  EXPECT_THAT(found(*shadow), Not(Contains("guard: not fallen")));
  for (const Judged& judged : shadow->judged()) {
    if (judged.to == Guard::fallen) {
      EXPECT_EQ(judged.truly, true);
    }
  }
}

TEST_P(ShadowTest, WhatIsPossibleIsWhatANavigatorInItsPlaceWouldDo) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> axis(-1.0, 1.0);
  int possible = 0;
  int others = 0;
  for (int run = 0; run < 12; ++run) {
    Command command;
    command.guide = kParts[random() % kParts.size()];
    for (double& value : command.axes)
      value = axis(random);
    if (run % 3 == 0) command.axes *= 0.2;
    if (is_foot(command.guide)) command.lift[side_of(command.guide)] = run % 2 == 0 ? 0.5 : 0.0;
    const auto later = [&](double t) { return t > 1.0 ? command : Command{}; };
    std::optional<Answer> answer;
    Simulation simulation(robot_, world_, Simulation::On::ideal, Simulation::Parameters{});
    Hooks hooks;
    hooks.plan = [&answer](const PlanRecord& record) {
      if (!answer) answer = record.answer;
    };
    simulation.session().add(hooks);
    while (simulation.session().t() < 1.5)
      simulation.session().step(later(simulation.session().t()));
    const auto shadow = watch({}, 1.2, still, later);
    if (!answer) {
      EXPECT_THAT(shadow->tried(), Each(testing::Field(&Tried::outcome, Tried::Outcome::nothing)));
      continue;
    }
    ASSERT_EQ(shadow->tried().size(), 1U);
    const Tried& tried = shadow->tried().front();
    EXPECT_NEAR(tried.t, 1.0, 2 * period_);
    if (const PlannedMotion* planned = answer->planned()) {
      EXPECT_EQ(tried.outcome, planned->limit ? Tried::Outcome::in_part : Tried::Outcome::possible);
      EXPECT_DOUBLE_EQ(tried.duration, planned->motion->duration());
      ++possible;
    } else if (answer->refusal() != nullptr) {
      EXPECT_EQ(tried.outcome, Tried::Outcome::refused);
      ASSERT_TRUE(tried.refusal);
      EXPECT_EQ(tried.refusal->reason, answer->refusal()->reason);
      ++others;
    } else {
      EXPECT_EQ(tried.outcome, Tried::Outcome::nothing);
      ++others;
    }
  }
  EXPECT_GT(possible, 3);
}

}  // namespace
}  // namespace baton::shadow
