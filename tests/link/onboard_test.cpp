#include "baton/link/onboard.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "baton/link/echoed_planning.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/proving/stick.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/served.hpp"

namespace baton::link {
namespace {

using test::complaint;
using test::hello;
using test::Raw;
using test::refused;
using test::Served;
using testing::HasSubstr;

/// A session that lives through what a robot at the other end does.
class Echo {
 public:
  Echo(const RobotModel& model, const Served& served, const NavigationOptions& navigation = {}) {
    RemoteRobot::Parameters parameters{served.address(), ""};
    parameters.navigation = navigation;
    auto connected = std::make_unique<RemoteRobot>(model, "flat", parameters);
    robot = connected.get();
    planning_ = std::make_unique<EchoedPlanning>(
        *robot, std::make_unique<DirectPlanning>(model, served.world(), navigation.modes));
    Simulation::Parameters simulation;
    simulation.session = {navigation.modes, navigation.source, planning_.get()};
    simulation_.emplace(model, served.world(), std::move(connected), simulation);
  }
  void step(const Command& command) {
    const Command followed = robot->guide(command);
    for (const ArmTargets& targets : robot->accepted_arms())
      simulation_->session().drive_arms(targets);
    simulation_->session().step(followed);
  }
  [[nodiscard]] const Session& session() const { return simulation_->session(); }
  [[nodiscard]] const Truth& truth() const { return simulation_->truth(); }

  RemoteRobot* robot = nullptr;

 private:
  std::unique_ptr<Planning> planning_;
  std::optional<Simulation> simulation_;
};

class OnboardTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
  const double period_ = robot_.profile().tick.period;

  [[nodiscard]] int ticks(double time) const { return static_cast<int>(std::lround(time / period_)); }
  /// Says what a driver says up to the first measurement.
  void start(Raw& raw) const {
    raw.send(Type::hello, hello());
    const Message welcome = raw.answer();
    ASSERT_EQ(welcome.type, Type::welcome);
    EXPECT_TRUE(decode_welcome(welcome.body).navigates);
    raw.send(Type::start, encode(start_of(robot_)));
    EXPECT_EQ(raw.answer().type, Type::measurement);
  }
  /// Arms that move for some seconds.
  [[nodiscard]] ArmTargets arms() const {
    ArmTargets targets = released_arms(robot_);
    targets.t = {0.5, 1.5, 2.5, 3.5};
    targets.q.resize(4, static_cast<Eigen::Index>(targets.joints.size()));
    Eigen::Index column = 0;
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side)) {
        const double home = robot_.joints()[static_cast<std::size_t>(j)].home;
        targets.q.col(column++) << home, home + 0.3, home - 0.3, home;
      }
    }
    return targets;
  }
  [[nodiscard]] Tick tick(const Message& message) const {
    EXPECT_EQ(message.type, Type::tick);
    return decode_tick(message.body, n_);
  }
  /// A robot that goes on by its own clock, on the plant `real`.
  [[nodiscard]] std::unique_ptr<Served> in_real_time(int seed) const {
    return std::make_unique<Served>(robot_, plant_of(true, nullptr, robot_, seed, 1.0), "", Served::Pace::by_test,
                                    true);
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, OnboardTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(OnboardTest, InLockStepARunIsTheSameBitByBitAsWithTheSimulatorInside) {
  for (const auto& [name, times] :
       std::vector<std::pair<std::string, double>>{{"push", 2.0}, {"glitches", 2.0}, {"push_fore", 2.5}}) {
    const Scenario& scenario = scenario_named(name);
    const Plant plant = plant_of(true, &scenario, robot_, 5, times);
    Served served(robot_, plant, "", Served::Pace::lock_step, true);
    Simulation::Parameters parameters;
    parameters.physics.plant = plant;
    parameters.session.modes.gait = Gait::stop;  // what the driver asks for counts
    Simulation here(robot_, served.world(), Simulation::On::sim, parameters);
    Echo there(robot_, served, {parameters.session.modes, StateSource::sensors});
    const std::unique_ptr<Device> stick = stick_of(scenario, robot_, 5);
    while (here.session().t() < 5.0 && !here.session().fallen()) {
      const Command command = stick->read(here.session().t());
      here.session().step(command);
      there.step(command);
      ASSERT_EQ(here.truth().q, there.truth().q) << name << " at " << here.session().t();
      ASSERT_EQ(here.truth().sole.left.force, there.truth().sole.left.force);
      ASSERT_EQ(here.session().navigator().anchor().p, there.session().navigator().anchor().p);
      ASSERT_EQ(here.session().navigator().committed(), there.session().navigator().committed());
      ASSERT_EQ(here.session().fallen(), there.session().fallen());
    }
    EXPECT_GT(here.session().t(), 0.5);
    EXPECT_EQ(here.truth().fall, there.truth().fall);
    EXPECT_EQ(there.robot->stale(), 0);
  }
}

TEST_P(OnboardTest, ADriverThatIsGoneAtAnyTimeLeavesARobotThatComesToRestOnBothFeet) {
  int mid_motion = 0;
  for (int seed = 0; seed < 6; ++seed) {
    const auto served = in_real_time(seed);
    Stick stick(static_cast<std::uint64_t>(seed) + 100, period_);
    {
      Raw raw(served->address());
      start(raw);
      const int gone = ticks(1.5) + 37 * seed;
      for (int k = 0; k < gone; ++k) {
        served->pass(1);
        EXPECT_EQ(tick(raw.answer()).reading.sequence, static_cast<std::uint64_t>(k));
        raw.send(Type::command, encode(StickPosition{static_cast<std::uint64_t>(k) + 1, stick.next()}));
      }
      served->at_the_robot([&](RobotServer& server) { mid_motion += server.onboard()->session().resting() ? 0 : 1; });
    }
    for (int k = 0; k < ticks(6.0) / 15; ++k)
      served->pass(15);
    served->at_the_robot([&](RobotServer& server) {
      EXPECT_EQ(server.state(), RobotServer::State::waiting);
      EXPECT_TRUE(server.onboard()->rests());
      EXPECT_FALSE(served->truth().fallen);
      EXPECT_GT(served->truth().q[2], 0.7 * robot_.profile().stance.com_height);
    });
  }
  EXPECT_GT(mid_motion, 1);
}

TEST_P(OnboardTest, AStickCountsForHalfASecondAndAgainWhenItIsFresh) {
  const auto served = in_real_time(1);
  Raw raw(served->address());
  start(raw);
  Command ahead;
  ahead.axes[0] = 1.0;
  std::uint64_t newest = 0;
  const auto pass = [&](int count, bool sees) {
    int followed = 0;
    for (int k = 0; k < count; ++k) {
      served->pass(1);
      const Tick seen = tick(raw.answer());
      EXPECT_EQ(seen.command == ahead, !seen.stale && seen.reading.sequence > 0);
      followed += seen.command == ahead ? 1 : 0;
      if (sees) newest = seen.reading.sequence + 1;
      raw.send(Type::command, encode(StickPosition{newest, ahead}));
    }
    return followed;
  };
  EXPECT_EQ(pass(ticks(0.8), true), ticks(0.8) - 1);
  // It goes on to send what it asked for when it knew of that tick.
  EXPECT_NEAR(pass(ticks(3.0), false), ticks(Onboard::kFresh), 1);
  EXPECT_THAT(served->log(), HasSubstr("link: the stick's positions are more than 0.5 s old: comes to rest"));
  served->at_the_robot([](RobotServer& server) { EXPECT_TRUE(server.onboard()->session().resting()); });
  newest += static_cast<std::uint64_t>(ticks(3.0));
  EXPECT_GE(pass(ticks(1.0), true), ticks(1.0) - 1);
  EXPECT_THAT(served->log(), HasSubstr("link: the stick counts again"));
  served->at_the_robot([](RobotServer& server) { EXPECT_FALSE(server.onboard()->session().resting()); });
}

TEST_P(OnboardTest, AFaultBringsTheRobotToRestForWhoeverDrivesUntilItIsOver) {
  for (const bool lock_step : {false, true}) {
    const auto served =
        lock_step ? std::make_unique<Served>(robot_, Plant{}, "", Served::Pace::lock_step, true) : in_real_time(1);
    Command ahead;
    ahead.axes[0] = 1.0;
    Echo echo(robot_, *served);
    const auto drive = [&](double time) {
      for (int k = 0; k < ticks(time); ++k) {
        if (!lock_step) served->pass(1);
        echo.step(ahead);
      }
    };
    drive(1.0);
    EXPECT_FALSE(echo.session().resting());
    served->at_the_robot([](RobotServer& server) { server.set_fault("left knee: winding too hot"); });
    echo.robot->drive_arms(arms());
    drive(4.0);
    EXPECT_TRUE(echo.session().resting());
    EXPECT_EQ(echo.robot->fault(), "left knee: winding too hot");
    EXPECT_EQ(echo.robot->rejected(), 1);
    EXPECT_THAT(echo.robot->rejection(), HasSubstr("something is wrong with the robot"));
    EXPECT_THAT(served->log(), HasSubstr("fault: left knee: winding too hot: comes to rest"));
    served->at_the_robot([](RobotServer& server) { server.set_fault(""); });
    drive(1.0);
    EXPECT_EQ(echo.robot->fault(), "");
    EXPECT_FALSE(echo.session().resting());
  }
  const auto served = in_real_time(1);
  served->at_the_robot([](RobotServer& server) { server.set_fault("left knee: winding too hot"); });
  Raw raw(served->address());
  raw.send(Type::hello, hello());
  EXPECT_EQ(raw.answer().type, Type::welcome);
  raw.send(Type::start, encode(start_of(robot_)));
  const Message fault = raw.answer();
  EXPECT_EQ(fault.type, Type::fault);
  EXPECT_EQ(decode_text(fault.body), "left knee: winding too hot");
  EXPECT_EQ(raw.answer().type, Type::measurement);
}

TEST_P(OnboardTest, ACommandThatWasOvertakenIsIgnored) {
  const auto served = in_real_time(1);
  Raw raw(served->address());
  start(raw);
  Command ahead;
  ahead.axes[0] = 1.0;
  for (std::uint64_t k = 0; k < 20; ++k) {
    served->pass(1);
    const Tick seen = tick(raw.answer());
    EXPECT_EQ(seen.command, Command{}) << k;
    raw.send(Type::command, encode(StickPosition{k + 1, {}}));
    raw.send(Type::command, encode(StickPosition{k, ahead}));
  }
}

TEST_P(OnboardTest, WhatIsOutOfPlaceEndsTheConnectionAndNotTheMotion) {
  const VecX zero = VecX::Zero(n_);
  const std::vector<std::pair<std::string, std::string>> cases{
      {framed(Type::target, encode(Target{0, zero, zero, zero})), "a target: must be a command"},
      {framed(Type::command, encode(StickPosition{9, {}})), "a command after tick 9: must be at most 3"},
      {framed(Type::command, "short"), "of 5 bytes: must be 74"},
      {framed(Type::damp, encode(StickPosition{3, {}})), "text"},  // a command but for a bit of its type
      {framed(Type::tick, ""), "a message of type 12 from a driver"},
      {framed(Type::start, encode(start_of(robot_))), "a second start"},
  };
  for (const auto& [message, named] : cases) {
    const auto served = in_real_time(2);
    Raw raw(served->address());
    start(raw);
    served->pass(3);
    for (int k = 0; k < 3; ++k)
      (void)tick(raw.answer());
    raw.send(message);
    EXPECT_THAT(refused(raw.answer()), HasSubstr(named));
    EXPECT_TRUE(raw.closed());
    served->pass(10);
    served->at_the_robot([&](RobotServer& server) { EXPECT_EQ(server.onboard()->ticks(), 13U); });
  }
  Served served(robot_, {}, "", Served::Pace::lock_step, true);
  Raw raw(served.address());
  start(raw);
  raw.send(Type::command, encode(StickPosition{0, {}}));
  (void)tick(raw.answer());
  raw.send(Type::command, encode(StickPosition{0, {}}));  // twice
  EXPECT_THAT(refused(raw.answer()), HasSubstr("a command after tick 0: must be 1"));
}

TEST_P(OnboardTest, TargetsForTheArmsAreSentBackBeforeTheTickInWhichTheyCountOrRejected) {
  ArmTargets unknown = arms();
  unknown.joints.front() = "tail";
  for (const bool lock_step : {true, false}) {
    Served served(robot_, {}, "", lock_step ? Served::Pace::lock_step : Served::Pace::by_test, true);
    Raw raw(served.address());
    start(raw);
    raw.send(Type::arms, encode(arms()));
    raw.send(Type::arms, encode(unknown));
    const Message accepted = raw.answer();
    EXPECT_EQ(accepted.type, Type::arms);
    EXPECT_EQ(accepted.body, encode(arms()));
    const Message rejected = raw.answer();
    EXPECT_EQ(rejected.type, Type::rejected);
    EXPECT_THAT(decode_text(rejected.body), HasSubstr("joint \"tail\" is none of an arm"));
    raw.send(Type::command, encode(StickPosition{}));
    if (!lock_step) served.pass(1);
    EXPECT_EQ(tick(raw.answer()).reading.sequence, 0U);
    damp(served.address(), "");
    EXPECT_EQ(raw.answer().type, Type::damp);
    raw.send(Type::arms, encode(arms()));
    const Message damped = raw.answer();
    EXPECT_EQ(damped.type, Type::rejected);
    EXPECT_THAT(decode_text(damped.body), HasSubstr("the robot is damped"));
  }
}

TEST_P(OnboardTest, ManyTargetsForTheArmsDoNotEndAConnectionThatTakesLittleAtATime) {
  ArmTargets many = arms();
  const auto columns = static_cast<Eigen::Index>(many.joints.size());
  const auto rows = static_cast<Eigen::Index>(ArmTrajectory::kMostNumbers) / columns - 1;  // and where they are now
  many.t.clear();
  for (Eigen::Index row = 0; row < rows; ++row)
    many.t.push_back(1.0 + static_cast<double>(row) / 30.0);
  many.q = 0.1 * MatX::Random(rows, columns);
  Served served(robot_, {}, "", Served::Pace::lock_step, true);
  Raw raw(served.address());
  start(raw);
  raw.narrow();
  raw.send(Type::arms, encode(many));
  raw.send(Type::command, encode(StickPosition{}));
  served.pass(0);
  const Message accepted = raw.answer();
  EXPECT_EQ(accepted.type, Type::arms);
  EXPECT_EQ(accepted.body, encode(many));
  EXPECT_EQ(tick(raw.answer()).reading.sequence, 0U);
}

TEST_P(OnboardTest, ADriverThatIsFarBehindStillHearsWhyItIsRefused) {
  Served served(robot_, {}, "", Served::Pace::by_test, true);
  Raw raw(served.address());
  start(raw);
  raw.narrow();
  for (int k = 0; k < ticks(2.0); k += 10)
    served.pass(10);
  raw.send(Type::target, "");
  for (int k = 0; k < 10; ++k) {
    served.pass(0);
    raw.send(Type::command, encode(StickPosition{}));
  }
  Message message = raw.answer();
  while (message.type == Type::tick)
    message = raw.answer();
  EXPECT_THAT(refused(message), HasSubstr("a target: must be a command"));
}

TEST_P(OnboardTest, ArmsThatAreRejectedForLongDoNotEndARun) {
  Served served(robot_, {}, "", Served::Pace::lock_step, true);
  Echo echo(robot_, served);
  ArmTargets unknown = arms();
  unknown.joints.front() = "tail";
  for (int k = 0; k < 100; ++k) {
    echo.robot->drive_arms(unknown);
    echo.step(Command{});
    ASSERT_EQ(echo.robot->rejected(), k + 1);
    ASSERT_EQ(echo.robot->follows_no_longer(), "");
  }
}

TEST_P(OnboardTest, BothEndsDriveTheArmsAlikeWhateverTimeIsLeftOut) {
  for (const double left_out : {0.2, 0.7}) {
    const auto served = in_real_time(6);
    Echo echo(robot_, *served);
    const auto pass = [&](int count) {
      served->pass(count);
      std::uint64_t there = 0;
      served->at_the_robot([&](RobotServer& server) { there = server.onboard()->ticks(); });
      for (auto here = static_cast<std::uint64_t>(std::lround(echo.session().t() / period_)); here < there; ++here)
        echo.step(Command{});  // throws if it comes to anything else than the robot
    };
    const auto pass_evenly = [&](double time) {
      for (int k = 0; k < ticks(time); k += 5)
        pass(5);
    };
    echo.robot->drive_arms(arms());
    pass_evenly(1.0);
    EXPECT_FALSE(echo.session().resting());
    pass(ticks(left_out));
    EXPECT_THAT(served->log(), HasSubstr("time was left out"));
    pass_evenly(1.0);
    EXPECT_EQ(echo.robot->stale() > 0, left_out > Onboard::kFresh);
    EXPECT_EQ(echo.session().resting(), left_out > Onboard::kFresh);
    echo.robot->drive_arms(arms());
    pass_evenly(0.5);
    EXPECT_FALSE(echo.session().resting());
    EXPECT_EQ(echo.robot->rejected(), 0);
  }
}

TEST_P(OnboardTest, InRealTimeAChangeOfTheStickIsSentBeforeTheTickHasCome) {
  Command ahead;
  ahead.axes[0] = 1.0;
  for (const bool lock_step : {true, false}) {
    Served served(robot_, {}, "", lock_step ? Served::Pace::lock_step : Served::Pace::by_test, true);
    RemoteRobot remote(robot_, "flat", RemoteRobot::Parameters{served.address(), ""});
    std::atomic<int> looks{0};
    Command followed;
    std::thread driver([&] { followed = remote.guide([&] { return looks++ == 0 ? Command{} : ahead; }); });
    while (!lock_step && looks < 3)
      std::this_thread::yield();
    if (!lock_step) served.pass(1);
    driver.join();
    EXPECT_EQ(followed == ahead, !lock_step);
    EXPECT_EQ(looks == 1, lock_step);
  }
}

TEST_P(OnboardTest, ABareRobotTakesNoCommands) {
  Served served(robot_);
  Raw raw(served.address());
  raw.send(Type::hello, hello());
  EXPECT_FALSE(decode_welcome(raw.answer().body).navigates);
  raw.send(Type::start, encode(start_of(robot_)));
  EXPECT_EQ(raw.answer().type, Type::measurement);
  raw.send(Type::command, encode(StickPosition{}));
  EXPECT_THAT(refused(raw.answer()), HasSubstr("a command: must be a target"));
}

TEST_P(OnboardTest, DampedItsNavigatorGivesUpAndTheNextDriverBeginsAnew) {
  for (const bool lock_step : {true, false}) {
    Served served(robot_, {}, "", lock_step ? Served::Pace::lock_step : Served::Pace::by_test, true);
    Raw raw(served.address());
    start(raw);
    std::uint64_t seen = 0;
    const auto next = [&] {
      if (!lock_step) served.pass(1);
      raw.send(Type::command, encode(StickPosition{seen, {}}));
      return raw.answer();
    };
    for (; seen < 20; ++seen)
      EXPECT_EQ(tick(next()).reading.sequence, seen);
    damp(served.address(), "");
    EXPECT_EQ(raw.answer().type, Type::damp);
    for (int k = 0; k < 400; ++k) {
      const Message message = next();
      ASSERT_EQ(message.type, Type::measurement);
      EXPECT_TRUE(decode_reading(message.body, n_).damped);
    }
    served.at_the_robot([&](RobotServer& server) {
      EXPECT_LT(served.truth().q[2], 0.8 * robot_.profile().stance.com_height);
      server.arm();
      EXPECT_EQ(server.onboard(), nullptr);
    });
    if (!lock_step) served.pass(100);  // nobody moves it
    Raw again(served.address());
    start(again);
    served.at_the_robot(
        [&](RobotServer&) { EXPECT_GT(served.truth().q[2], 0.8 * robot_.profile().stance.com_height); });
  }
}

TEST_P(OnboardTest, ADriverNoticesThatTheRobotWasDampedOrComesToSomethingElse) {
  {
    Served served(robot_, {}, "", Served::Pace::lock_step, true);
    Echo echo(robot_, served);
    echo.step(Command{});
    damp(served.address(), "");
    EXPECT_THAT(complaint([&] { echo.step(Command{}); }),
                HasSubstr("the robot was damped: asked for over the network"));
  }
  Served served(robot_, {}, "", Served::Pace::lock_step, true);
  // The session here has other modes than the robot's.
  RemoteRobot::Parameters parameters{served.address(), ""};
  auto connected = std::make_unique<RemoteRobot>(robot_, "flat", parameters);
  RemoteRobot& remote = *connected;
  EchoedPlanning planning(remote,
                          std::make_unique<DirectPlanning>(robot_, served.world(),
                                                           Modes{DurationRule::search, OnLimit::shrink, Gait::stop}));
  Simulation::Parameters other;
  other.session.planning = &planning;
  Simulation simulation(robot_, served.world(), std::move(connected), other);
  Command ahead;
  ahead.axes[0] = 0.7;
  EXPECT_THAT(complaint([&] {
                for (int k = 0; k < 2000; ++k)
                  simulation.session().step(remote.guide(ahead));
              }),
              testing::AnyOf(HasSubstr("its navigator came to another target than the one here"),
                             HasSubstr("plans something else than is planned here")));
}

/// A robot's end that balances a robot at another one, which follows targets and goes on when it has got one.
class Between {
 public:
  explicit Between(const RobotModel& model, int seed)
      : bare_(model, plant_of(true, nullptr, model, seed, 1.0), "", Served::Pace::by_answers),
        remote_(model, "flat", RemoteRobot::Parameters{bare_.address(), ""}),
        server_(model, remote_,
                {.listen = {"127.0.0.1", 0},
                 .on = "sim",
                 .world = "flat",
                 .real_time = true,
                 .navigates_in = &bare_.world(),
                 .remote = &remote_,
                 .log = [this](const std::string& line) { log += line + '\n'; }}) {}

  void pass(int ticks) {
    for (int k = 0; k < ticks; ++k)
      server_.serve(Socket::Time(0));
  }
  /// What the driver hears next.
  Message answer(Raw& raw) {
    pass(2);
    return raw.answer();
  }
  [[nodiscard]] RobotServer& server() { return server_; }
  [[nodiscard]] Served& bare() { return bare_; }

  std::string log;

 private:
  Served bare_;
  RemoteRobot remote_;
  RobotServer server_;
};

TEST_P(OnboardTest, ADriverThatComesBackInAStepIsRefusedUntilTheRobotRests) {
  Between between(robot_, 3);
  const auto begin = [&](Raw& raw) {
    raw.send(Type::hello, hello());
    EXPECT_EQ(between.answer(raw).type, Type::welcome);
    raw.send(Type::start, encode(start_of(robot_)));
    return between.answer(raw);
  };
  Command ahead;
  ahead.axes[0] = 1.0;
  const auto one_foot = [&] {
    const BySide<bool>& contact = between.server().onboard()->session().navigator().sample().contact;
    return !contact.left || !contact.right;
  };
  {
    Raw raw(between.server().address());
    EXPECT_EQ(begin(raw).type, Type::measurement);
    for (int k = 0; k < ticks(6.0) && !one_foot(); ++k) {
      raw.send(Type::command, encode(StickPosition{between.server().onboard()->ticks(), ahead}));
      between.pass(1);
    }
    ASSERT_TRUE(one_foot());
  }
  const Onboard* navigator = between.server().onboard();
  {
    Raw again(between.server().address());
    EXPECT_THAT(refused(begin(again)), HasSubstr("posture: the robot is still coming to rest"));
  }
  EXPECT_EQ(between.server().onboard(), navigator);
  for (int k = 0; k < ticks(8.0) && !between.server().resting(); ++k)
    between.pass(1);
  between.pass(ticks(0.5));
  EXPECT_TRUE(between.server().resting());
  EXPECT_THAT(between.log, HasSubstr("at rest, without a driver"));
  Raw next(between.server().address());
  EXPECT_EQ(begin(next).type, Type::measurement);  // from where it stands
  between.pass(ticks(1.0));
  between.bare().at_the_robot([&](RobotServer&) {
    EXPECT_FALSE(between.bare().truth().fallen);
    EXPECT_GT(between.bare().truth().q[2], 0.7 * robot_.profile().stance.com_height);
  });
}

TEST_P(OnboardTest, DampingReachesTheRobotBehindWhichIsArmedAtItsOwnEnd) {
  Between between(robot_, 4);
  Raw raw(between.server().address());
  raw.send(Type::hello, hello());
  EXPECT_EQ(between.answer(raw).type, Type::welcome);
  raw.send(Type::start, encode(start_of(robot_)));
  EXPECT_EQ(between.answer(raw).type, Type::measurement);
  between.pass(20);
  between.server().damp("by a key");
  between.pass(20);
  between.bare().at_the_robot([](RobotServer& server) { EXPECT_EQ(server.state(), RobotServer::State::damped); });
  between.server().arm();
  EXPECT_EQ(between.server().state(), RobotServer::State::damped);
  EXPECT_THAT(between.log, HasSubstr("not armed: arm the robot at its own end"));
  between.bare().at_the_robot([](RobotServer& server) { server.arm(); });
  EXPECT_THAT(complaint([&] { between.pass(20); }), HasSubstr(between.bare().address().text()));
}

TEST_P(OnboardTest, AnEndThatIsEndedComesToRestBeforeAndTakesNoOtherDriver) {
  const auto served = in_real_time(5);
  Raw raw(served->address());
  start(raw);
  Command ahead;
  ahead.axes[0] = 1.0;
  std::uint64_t seen = 0;
  bool rests = true;
  for (; seen < static_cast<std::uint64_t>(ticks(6.0)) && rests; ++seen) {
    served->pass(1);
    (void)tick(raw.answer());
    raw.send(Type::command, encode(StickPosition{seen + 1, ahead}));
    served->at_the_robot([&](RobotServer& server) { rests = server.resting(); });
  }
  ASSERT_FALSE(rests);
  served->at_the_robot([](RobotServer& server) { server.retire(); });
  EXPECT_EQ(raw.answer().type, Type::bye);
  Raw other(served->address());
  other.send(Type::hello, hello());
  EXPECT_THAT(refused(other.answer()), HasSubstr("busy: the robot's end is being ended"));
  for (int k = 0; k < ticks(6.0) / 15; ++k)
    served->pass(15);
  served->at_the_robot([](RobotServer& server) { EXPECT_TRUE(server.resting()); });
}

/// It measures the same, whatever it is told.
class Statue : public Robot {
 public:
  explicit Statue(Measurement measurement) : measurement_(std::move(measurement)) {}
  Measurement read() override { return measurement_; }
  void write(const JointTarget&) override {}
  void reset() override {}

 private:
  Measurement measurement_;
};

TEST_P(OnboardTest, ARobotThatDoesNotStandOrMeasuresTooLittleIsRefused) {
  const World world = World::load("flat");
  SimulatedRobot simulated(robot_, world, stand(robot_, world.site("start"), robot_.profile().stance.com_height),
                           period_, {});
  const auto refusal = [&](StateSource source, const std::function<void(Measurement&)>& change) {
    Measurement measurement = simulated.read();
    change(measurement);
    Statue statue(measurement);
    RobotServer server(robot_, statue, {.listen = {"127.0.0.1", 0}, .world = "flat", .navigates_in = &world});
    Raw raw(server.address());
    const auto said = [&](Type type, const std::string& body) {
      raw.send(type, body);
      for (int k = 0; k < 50; ++k)
        server.serve(Socket::Time(1));
      return raw.answer();
    };
    EXPECT_EQ(said(Type::hello, hello()).type, Type::welcome);
    Start start = start_of(robot_);
    start.navigation = NavigationOptions{{}, source};
    const std::string why = refused(said(Type::start, encode(start)));
    EXPECT_EQ(server.onboard() == nullptr, !why.empty());
    return why;
  };
  const Vec3 unknown = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  const auto sensors = StateSource::sensors;
  EXPECT_EQ(refusal(sensors, [](Measurement&) {}), "");
  const auto hip = robot_.leg(Side::left).front();
  EXPECT_THAT(refusal(sensors, [&](Measurement& m) { m.q[hip] += 0.6; }), HasSubstr("posture: "));
  EXPECT_THAT(refusal(sensors, [&](Measurement& m) { m.q[hip] = unknown.x(); }), HasSubstr("posture: "));
  EXPECT_THAT(refusal(sensors,
                      [&](Measurement& m) {
                        m.sole = {{unknown, unknown}, {unknown, unknown}};
                      }),
              HasSubstr("sensors: --state sensors: measures no forces on its soles: must be --state torques"));
  EXPECT_THAT(refusal(StateSource::torques, [](Measurement& m) { m.torque.resize(0); }),
              HasSubstr("sensors: --state torques: measures no motor torques"));
  EXPECT_THAT(refusal(StateSource::perfect, [](Measurement& m) { m.root.reset(); }),
              HasSubstr("sensors: --state perfect: measures no pose of its root"));
}

}  // namespace
}  // namespace baton::link
