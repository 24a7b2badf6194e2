/// What a run says of sensors that are not believed, and of a robot that has fallen by them.
#include "baton/run/condition_log.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <limits>
#include <random>
#include <thread>

#include "baton/proving/scenario.hpp"
#include "tests/support/glitches.hpp"
#include "tests/support/glitchy_robot.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"
#include "tests/support/served.hpp"

namespace baton {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ConditionLogTest : public testing::Test {
 protected:
  const RobotModel& model_ = test::robot("mighty");
  const World flat_ = World::load("flat");
  const Posture start_ = stand(model_, flat_.site("start"), model_.profile().stance.com_height);

  /// What is said while `spoil` is done from 0.5 s until `until`, of a robot that is driven ahead for 4 s.
  std::vector<ConditionLog::Line> lines(const std::function<void(Measurement&)>& spoil, double until) {
    SimulatedRobot inside(model_, flat_, start_, model_.profile().tick.period);
    test::GlitchyRobot robot(inside);
    Session session(model_, flat_, robot, start_);
    ConditionLog log(model_);
    session.add(log);
    Command ahead;
    ahead.axes[0] = 1.0;
    while (session.t() < 4.0) {
      robot.spoil = session.t() >= 0.5 && session.t() < until ? spoil : nullptr;
      session.step(ahead);
    }
    EXPECT_FALSE(session.fallen());
    return log.take();
  }
};

TEST_F(ConditionLogTest, AReadingThatIsNotANumberIsShownWithTheJointThatItIsOf) {
  std::mt19937_64 random(3);
  const auto n = static_cast<std::size_t>(model_.nv() - 6);
  Measurement believed;
  believed.q = believed.dq = believed.torque = VecX::Zero(model_.nv() - 6);
  for (int round = 0; round < 1000; ++round) {
    const std::size_t j = std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    const auto row = static_cast<Eigen::Index>(j);
    const std::string& name = model_.joints()[j].name;
    Measurement read = believed;
    read.q = read.torque = VecX::Random(read.q.size());
    read.dq = VecX::Random(read.q.size());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    VecX& spoilt = round % 2 == 0 ? read.q : read.torque;
    spoilt[row] = nan;
    const Sensor sensor = round % 2 == 0 ? Sensor::encoders : Sensor::torques;
    EXPECT_THAT(rejected_reading(model_, sensor, read, believed), AllOf(HasSubstr(name), HasSubstr("nan")));
    read = believed;
    read.dq[row] = 55.0;
    EXPECT_THAT(rejected_reading(model_, Sensor::encoders, read, believed),
                AllOf(HasSubstr(name), HasSubstr("55.00 rad/s")));
  }
}

TEST_F(ConditionLogTest, ASensorThatIsRejectedForLongIsNamedOnceAndAgainWhenItIsBelieved) {
  struct Case {
    const char* sensor;
    const char* shows;
    std::function<void(Measurement&)> spoil;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Case> cases{
      {"encoders", "left_knee_flexion at nan rad",
       [&](Measurement& m) {
         for (std::size_t j = 0; j < model_.joints().size(); ++j) {
           if (model_.joints()[j].name == "left_knee_flexion") m.q[static_cast<Eigen::Index>(j)] = nan;
         }
       }},
      {"attitude", "no rotation matrix: rows (1.00, ", [&](Measurement& m) { m.imu.attitude(1, 1) = nan; }},
      {"gyro", "(0.00, nan, 0.00) rad/s", [&](Measurement& m) { m.imu.rate = Vec3(0.0, nan, 0.0); }},
      {"accelerometer", "-9.8", [](Measurement& m) { m.imu.acceleration *= -1.0; }},
      {"forces", "left sole with (",
       [](Measurement& m) {
         for (const Side side : kSides)
           m.sole[side].force *= -1.0;
       }},
  };
  const auto turned = [](Measurement& m) { m.imu.attitude = rotation_exp(Vec3(0.5, 0.0, 0.0)) * m.imu.attitude; };
  Measurement read;
  turned(read);
  EXPECT_EQ(rejected_reading(model_, Sensor::attitude, read, Measurement{}),
            "turned by 0.50 rad from what is expected, about (1.00, 0.00, 0.00) in its axes");
  for (const Case& one : cases) {
    const std::vector<ConditionLog::Line> said = lines(one.spoil, 2.5);
    ASSERT_EQ(said.size(), 2U) << one.sensor;
    EXPECT_TRUE(said[0].warning);
    EXPECT_STREQ(said[0].what, "sensor");
    EXPECT_THAT(said[0].text,
                AllOf(HasSubstr(std::string(one.sensor) + ": readings are rejected: "), HasSubstr(one.shows)));
    EXPECT_GT(said[0].t, 0.7);
    EXPECT_LT(said[0].t, 1.2) << one.sensor;
    EXPECT_FALSE(said[1].warning);
    EXPECT_EQ(said[1].text, std::string(one.sensor) + ": readings are plausible again");
    EXPECT_GT(said[1].t, 2.4);
    EXPECT_LT(said[1].t, 3.2) << one.sensor;
  }
}

TEST_F(ConditionLogTest, OfReadingsThatAreBelievedNothingIsSaid) {
  EXPECT_TRUE(lines([](Measurement&) {}, 4.0).empty());
  std::mt19937_64 random(7);
  int ticks = 0;  // a glitch now and then is bridged
  const auto glitch = [&](Measurement& m) {
    if (++ticks % 40 == 0)
      test::glitches()[static_cast<std::size_t>(ticks / 40) % test::glitches().size()].spoil(m, random);
  };
  EXPECT_TRUE(lines(glitch, 4.0).empty());
}

TEST_F(ConditionLogTest, ASensorThatComesAndGoesIsSpokenOfNowAndThenAndAtLastIfItStaysAway) {
  SimulatedRobot inside(model_, flat_, start_, model_.profile().tick.period);
  test::GlitchyRobot robot(inside);
  Session session(model_, flat_, robot, start_);
  ConditionLog log(model_);
  session.add(log);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto step_until = [&](double end, const std::function<bool(double)>& gone) {
    while (session.t() < end) {
      robot.spoil = gone(session.t()) ? [nan](Measurement& m) { m.q[0] = nan; } : std::function<void(Measurement&)>();
      session.step(Command{});
    }
    return log.take();
  };
  std::size_t warnings = 0;
  for (const ConditionLog::Line& line : step_until(12.0, [](double t) { return std::fmod(t, 1.0) < 0.5; }))
    warnings += line.warning ? 1 : 0;
  EXPECT_GE(warnings, 2U);
  EXPECT_LE(warnings, 3U);
  static_cast<void>(step_until(18.0, [](double) { return false; }));
  const std::vector<ConditionLog::Line> said =
      step_until(28.0, [](double t) { return t < 18.5 || t > 19.5; });  // gone, there, and gone for good
  ASSERT_EQ(said.size(), 3U);
  EXPECT_TRUE(said.back().warning);
  EXPECT_LT(said.back().t, 24.0);
}

TEST_F(ConditionLogTest, ReadingsThatFreezeAreOneLineAlsoWithoutTorques) {
  for (const StateSource source : {StateSource::sensors, StateSource::torques}) {
    SimulatedRobot inside(model_, flat_, start_, model_.profile().tick.period);
    test::GlitchyRobot robot(inside);
    Session session(model_, flat_, robot, start_, {{}, source});
    ConditionLog log(model_);
    session.add(log);
    Command ahead;
    ahead.axes[0] = 1.0;
    while (session.t() < 1.0)
      session.step(ahead);
    const Measurement frozen = inside.read();
    robot.spoil = [&](Measurement& m) {
      m = frozen;
      m.torque.resize(0);
    };
    while (session.t() < 3.0)
      session.step(ahead);
    const std::vector<ConditionLog::Line> said = log.take();
    std::vector<std::string> of_sensors;
    for (const ConditionLog::Line& line : said) {
      if (std::string(line.what) == "sensor") of_sensors.push_back(line.text);
    }
    ASSERT_FALSE(of_sensors.empty()) << to_string(source);
    EXPECT_THAT(of_sensors[0], HasSubstr("all readings stay the same"));
    EXPECT_LE(of_sensors.size(), 3U) << "once it rests, they may be possible";
  }
  Measurement none;
  none.torque.resize(0);
  EXPECT_EQ(rejected_reading(model_, Sensor::torques, none, none), "none");
}

/// A robot's end, in a thread, whose robot tells nothing but what its sensors read.
class WithoutTruth {
 public:
  WithoutTruth(const RobotModel& model, const World& world, const Posture& start, const Plant& plant)
      : inside_(model, world, start, model.profile().tick.period, {.plant = plant}),
        server_(model, robot_, {.listen = {"127.0.0.1", 0}, .world = world.name()}),
        address(server_.address().text()) {
    robot_.hidden = true;
    thread_ = std::thread([this] {
      while (!stop_)
        server_.serve(Socket::Time(1));
    });
  }
  ~WithoutTruth() {
    stop_ = true;
    thread_.join();
  }

 private:
  SimulatedRobot inside_;
  test::GlitchyRobot robot_{inside_};
  link::RobotServer server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;

 public:
  const std::string address;
};

TEST_F(ConditionLogTest, ARobotWithoutTruthThatHasFallenSaysSoBySensors) {
  const test::Scratch scratch;
  const WithoutTruth end(model_, flat_, start_, plant_of(scenario_named("push"), model_, 0, 8.0));
  const test::Outcome fallen =
      test::run({"drive", "--on", end.address, "--world", "flat", "--fast", "--headless", "--seconds", "8", "--input",
                 "script:" + scratch.write("s.jsonl", R"({"t": 0})"), "--report", scratch.path("r.json")});
  EXPECT_EQ(fallen.code, app::kFallen) << fallen.err;
  EXPECT_THAT(fallen.out, HasSubstr("fallen, by its sensors"));
  EXPECT_THAT(fallen.err, HasSubstr("has fallen, by its sensors: its motors give no torque"));
  EXPECT_THAT(scratch.json("r.json")["link"]["notes"].dump(), HasSubstr("has fallen"));
}

}  // namespace
}  // namespace baton
