#include "baton/link/robot_server.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

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
using test::kLinkPatience;
using test::Raw;
using test::refused;
using test::Served;
using testing::HasSubstr;

class RobotServerTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;

  [[nodiscard]] Reading reading(const Message& message) const {
    EXPECT_EQ(message.type, Type::measurement);
    return decode_reading(message.body, n_);
  }
  /// Says what a driver says up to the first measurement.
  void start(Raw& raw) const {
    raw.send(Type::hello, hello());
    EXPECT_EQ(raw.answer().type, Type::welcome);
    raw.send(Type::start, encode(start_of(robot_)));
  }
  [[nodiscard]] Simulation remote(Served& served, const std::string& token = "") const {
    return {robot_, served.world(),
            std::make_unique<RemoteRobot>(robot_, "flat", RemoteRobot::Parameters{served.address(), token}),
            Simulation::Parameters{}};
  }
  [[nodiscard]] Simulation inside(const World& world, const Plant& plant) const {
    Simulation::Parameters parameters;
    parameters.physics.plant = plant;
    return {robot_, world, Simulation::On::sim, parameters};
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, RobotServerTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(RobotServerTest, ARunIsTheSameBitByBitAsWithTheSimulatorInside) {
  for (const auto& [name, times] :
       std::vector<std::pair<std::string, double>>{{"push", 2.0}, {"glitches", 2.0}, {"push_fore", 2.5}}) {
    const Scenario& scenario = scenario_named(name);
    const Plant plant = plant_of(true, &scenario, robot_, 5, times);
    Served served(robot_, plant);
    Simulation here = inside(served.world(), plant);
    Simulation there = remote(served);
    const std::unique_ptr<Device> stick = stick_of(scenario, robot_, 5);
    long ticks = 0;
    while (here.session().t() < 5.0 && !here.session().fallen()) {
      const Command command = stick->read(here.session().t());
      here.session().step(command);
      there.session().step(command);
      ASSERT_EQ(here.truth().q, there.truth().q) << name << " at " << here.session().t();
      ASSERT_EQ(here.truth().dq, there.truth().dq);
      ASSERT_EQ(here.truth().sole.left.force, there.truth().sole.left.force);
      ASSERT_EQ(here.session().fallen(), there.session().fallen());
      ++ticks;
    }
    EXPECT_EQ(here.truth().fall, there.truth().fall);
    EXPECT_GT(ticks, 200);
    EXPECT_EQ(served.log(), "a driver has taken over\n");  // and no target was rejected
  }
}

TEST_P(RobotServerTest, InRealTimeTheRunIsTheSameIfEachAnswerComesInTime) {
  const Scenario& scenario = scenario_named("push");
  const Plant plant = plant_of(true, &scenario, robot_, 6, 1.0);
  Served served(robot_, plant, "", Served::Pace::by_answers);
  Simulation here = inside(served.world(), plant);
  Simulation there = remote(served);
  const std::unique_ptr<Device> stick = stick_of(scenario, robot_, 6);
  while (here.session().t() < 3.0) {
    const Command command = stick->read(here.session().t());
    here.session().step(command);
    there.session().step(command);
    ASSERT_EQ(here.truth().q, there.truth().q) << " at " << here.session().t();
  }
  EXPECT_EQ(served.log(), "a driver has taken over\n");
}

TEST_P(RobotServerTest, InRealTimeADriverBeginsWithWhatIsMeasuredThen) {
  const double period = robot_.profile().tick.period;
  Served served(robot_, {}, "", Served::Pace::by_answers);
  auto connected = std::make_unique<RemoteRobot>(robot_, "flat", RemoteRobot::Parameters{served.address(), ""});
  RemoteRobot* const remote = connected.get();
  Simulation simulation(robot_, served.world(), std::move(connected), Simulation::Parameters{});
  for (int k = 0; k < 5; ++k)
    served.pass(15);  // while the driver prepares
  EXPECT_EQ(remote->read().t, 0.0);
  remote->catch_up();
  EXPECT_NEAR(remote->read().t, 75 * period, 1e-9);
  for (int tick = 0; tick < 100; ++tick)
    simulation.session().step(Command{});
  EXPECT_EQ(remote->rejected(), 0);
  EXPECT_NEAR(remote->read().t, 175 * period, 1e-9);
  EXPECT_NEAR(simulation.truth().q[2], robot_.profile().stance.com_height, 0.5 * robot_.profile().stance.com_height);
}

TEST_P(RobotServerTest, InRealTimeItGoesOnWithoutAnAnswerAndFollowsNoneThatIsTooOldOrComesTwice) {
  Served served(robot_, {}, "", Served::Pace::by_test);
  Raw raw(served.address());
  raw.send(Type::hello, hello());
  const Message welcome = raw.answer();
  ASSERT_EQ(welcome.type, Type::welcome);
  EXPECT_FALSE(decode_welcome(welcome.body).lock_step);
  raw.send(Type::start, encode(start_of(robot_)));
  const Reading first = reading(raw.answer());
  const VecX zero = VecX::Zero(n_);
  std::uint64_t newest = 0;
  const auto later = [&](int ticks) {
    served.pass(ticks);
    for (int tick = 0; tick < ticks; ++tick) {
      const Reading next = reading(raw.answer());
      EXPECT_EQ(next.sequence, ++newest);
      EXPECT_LT((next.measurement.q - first.measurement.q).cwiseAbs().maxCoeff(), 0.1);
    }
  };
  const auto rejected = [&](std::uint64_t sequence) {
    raw.send(Type::target, encode(Target{sequence, first.measurement.q, zero, zero}));
    served.pass(0);
    served.pass(1);
    Message message = raw.answer();
    std::string why;
    if (message.type == Type::rejected) {
      why = decode_text(message.body);
      message = raw.answer();
    }
    EXPECT_EQ(reading(message).sequence, ++newest);
    return why;
  };
  EXPECT_EQ(rejected(0), "");
  later(3);
  EXPECT_EQ(rejected(newest), "");
  EXPECT_THAT(rejected(newest - 1), HasSubstr("an answer to measurement"));  // twice
  later(10);
  EXPECT_EQ(rejected(newest - 5), "");                                       // late, and better than none
  EXPECT_THAT(rejected(newest - 8), HasSubstr("an answer to measurement"));  // out of order
  later(18);
  later(18);
  EXPECT_THAT(rejected(newest - 25), HasSubstr("an answer to measurement"));  // too old
  EXPECT_THAT(rejected(newest + 1), HasSubstr("an answer to measurement"));   // to what was not sent yet
  EXPECT_EQ(rejected(newest), "");
}

TEST_P(RobotServerTest, InRealTimeADampedRobotSinksThoughItsDriverIsGone) {
  Served served(robot_, {}, "", Served::Pace::by_test);
  {
    Raw raw(served.address());
    start(raw);
    EXPECT_EQ(raw.answer().type, Type::measurement);
  }
  while (served.log().find("lost") == std::string::npos) {
  }
  damp(served.address(), "");
  for (int k = 0; k < 30; ++k)
    served.pass(15);
  served.at_the_robot([&](RobotServer& server) {
    EXPECT_EQ(server.state(), RobotServer::State::damped);
    EXPECT_LT(served.truth().q[2], 0.8 * robot_.profile().stance.com_height);
  });
}

TEST_P(RobotServerTest, WhoeverDrivesNextBeginsAnewHoweverTheLastOneLeft) {
  const Plant plant = plant_of(true, nullptr, robot_, 3, 1.0);
  Served served(robot_, plant);
  std::mt19937_64 random(6);
  std::vector<VecX> first;
  for (int run = 0; run < 12; ++run) {
    const auto ticks = static_cast<std::size_t>(1 + random() % 60);
    if (run % 3 == 2) {  // cut in the middle of a message
      Raw raw(served.address());
      start(raw);
      EXPECT_EQ(raw.answer().type, Type::measurement);
      raw.send(framed(Type::target, std::string(100, 'x')).substr(0, random() % 100));
      continue;
    }
    Simulation simulation = remote(served);
    for (std::size_t tick = 0; tick < ticks; ++tick) {
      Command command;
      command.axes[0] = 1.0;
      simulation.session().step(command);
      if (tick < first.size()) {
        ASSERT_EQ(simulation.truth().q, first[tick]);
      } else {
        first.push_back(simulation.truth().q);
      }
    }
  }
  EXPECT_GT(first.size(), 20U);
  EXPECT_THAT(served.log(), HasSubstr("handed the robot back"));
  EXPECT_THAT(served.log(), HasSubstr("driver lost"));
}

TEST_P(RobotServerTest, WhoMayNotDriveIsToldWhy) {
  Served served(robot_, {}, "secret");
  for (const char* wrong : {"", "Secret", "secre", "secret "}) {
    Raw raw(served.address());
    raw.send(Type::hello, hello(kVersion, wrong));
    EXPECT_THAT(refused(raw.answer()), HasSubstr("token: "));
    EXPECT_TRUE(raw.closed());
  }
  {
    Raw malformed(served.address());
    malformed.send(Type::hello, "{\"baton\": 1, \"role\": \"king\"}");
    EXPECT_THAT(refused(malformed.answer()), HasSubstr("protocol: hello: role"));
    Raw strange(served.address());
    strange.send("GET / HTTP/1.1\r\n\r\n");
    EXPECT_THAT(refused(strange.answer()), HasSubstr("is this a baton link?"));
  }
  Raw old(served.address());
  old.send(Type::hello, hello(kVersion + 1, "secret"));
  EXPECT_THAT(refused(old.answer()), HasSubstr("version: version 2 of the protocol: must be 1"));

  EXPECT_THAT(complaint([&] { (void)remote(served, "guess"); }), HasSubstr("refused (token)"));
  Simulation driver = remote(served, "secret");
  EXPECT_THAT(complaint([&] { (void)remote(served, "secret"); }), HasSubstr("refused (busy)"));
  driver.session().step(Command{});  // undisturbed by that
  EXPECT_GT(driver.truth().t, 0.0);
}

TEST_P(RobotServerTest, AnAddressThatOthersReachNeedsAToken) {
  Simulation simulation = inside(World::load("flat"), {});
  EXPECT_THAT(complaint([&] {
                RobotServer(robot_, *simulation.simulated(), {.listen = {"0.0.0.0", 0}});
              }),
              HasSubstr("needs a token"));
  EXPECT_NO_THROW(RobotServer(robot_, *simulation.simulated(), {.listen = {"0.0.0.0", 0}, .token = "t"}));
}

TEST_P(RobotServerTest, ServosOfOtherGainsAreRefused) {
  Served served(robot_);
  for (int k = 0; k < 3; ++k) {
    Start start = start_of(robot_);
    if (k == 0) start.kp[1] *= 1.5;
    if (k == 1) start.kd[0] *= 0.5;
    if (k == 2) start.drive = start.drive == "stiff" ? "pd" : "stiff";
    Raw raw(served.address());
    raw.send(Type::hello, hello());
    EXPECT_EQ(raw.answer().type, Type::welcome);
    raw.send(Type::start, encode(start));
    const std::string why = refused(raw.answer());
    EXPECT_THAT(why, HasSubstr("servos: "));
    EXPECT_THAT(why, HasSubstr(k == 2 ? "drive" : robot_.joints()[k == 0 ? 1 : 0].name));
  }
}

TEST_P(RobotServerTest, ATargetThatJumpsOrComesOutOfOrderMovesNothing) {
  Served served(robot_);
  Raw raw(served.address());
  start(raw);
  const Reading first = reading(raw.answer());
  EXPECT_EQ(first.sequence, 0U);
  const VecX zero = VecX::Zero(n_);
  Target target{0, first.measurement.q, zero, zero};
  const Range& range = robot_.joints()[3].position;
  const double middle = 0.5 * (range.lo + range.hi);
  const std::vector<std::pair<std::function<void(Target&)>, std::string>> cases{
      {[&](Target& t) { t.q[3] += t.q[3] > middle ? -0.6 : 0.6; }, "jump"},
      {[](Target& t) { t.q[0] = std::numeric_limits<double>::quiet_NaN(); }, "finite"},
      {[](Target& t) { t.sequence += 1; }, "an answer to measurement"},
      {[](Target& t) { t.sequence -= 1; }, "an answer to measurement"},
      {[](Target& t) { t.tau[2] = 1e9; }, "torque"},
  };
  Reading last = first;
  for (const auto& [spoil, named] : cases) {
    target.sequence = last.sequence;
    Target bad = target;
    spoil(bad);
    raw.send(Type::target, encode(bad));
    const Message rejected = raw.answer();
    ASSERT_EQ(rejected.type, Type::rejected) << named;
    EXPECT_THAT(decode_text(rejected.body), HasSubstr(named));
    const Reading next = reading(raw.answer());
    EXPECT_EQ(next.sequence, last.sequence + 1);
    EXPECT_LT((next.measurement.q - first.measurement.q).cwiseAbs().maxCoeff(), 0.05);
    last = next;
  }
  target.sequence = last.sequence;
  raw.send(Type::target, encode(target));
  EXPECT_EQ(raw.answer().type, Type::measurement);
  EXPECT_THAT(served.log(), HasSubstr("target rejected"));
}

TEST_P(RobotServerTest, DampedItsMotorsOnlyBrakeUntilItIsArmedAtTheRobotsEnd) {
  Served served(robot_);
  for (const bool by_key : {true, false}) {
    Simulation simulation = remote(served);
    auto& session = simulation.session();
    for (int tick = 0; tick < 20; ++tick)
      session.step(Command{});
    const double height = simulation.truth().q[2];
    if (by_key) {
      served.at_the_robot([](RobotServer& server) { server.damp("by the robot's own key"); });
    } else {
      damp(served.address(), "");
    }
    EXPECT_THAT(complaint([&] { (void)remote(served); }), HasSubstr("refused (damped)"));
    for (int tick = 0; tick < 400; ++tick)
      session.step(Command{});
    EXPECT_LT(simulation.truth().q[2], 0.8 * height);  // whatever the navigator asked for
    served.at_the_robot([](RobotServer& server) {
      EXPECT_EQ(server.state(), RobotServer::State::damped);
      server.arm();
      EXPECT_EQ(server.state(), RobotServer::State::waiting);
    });
    EXPECT_THAT(complaint([&] { session.step(Command{}); }), HasSubstr(served.address().text()));
    Simulation again = remote(served);
    again.session().step(Command{});
    EXPECT_NEAR(again.truth().q[2], height, 0.01 * height);
  }
}

TEST_P(RobotServerTest, DampIsLatchedHoweverSoonItComes) {
  for (const bool started : {false, true}) {
    Served served(robot_);
    Raw raw(served.address());
    raw.send(framed(Type::hello, hello()) + (started ? framed(Type::start, encode(start_of(robot_))) : "") +
             framed(Type::damp, encode_text("at once")));  // in one piece
    EXPECT_EQ(raw.answer().type, Type::welcome);
    if (started) {
      EXPECT_FALSE(reading(raw.answer()).damped);
    }
    EXPECT_EQ(raw.answer().type, Type::damp);
    if (started) {
      const VecX zero = VecX::Zero(n_);
      raw.send(Type::target, encode(Target{0, VecX::Zero(n_), zero, zero}));
      Message message = raw.answer();
      if (message.type == Type::rejected) message = raw.answer();
      EXPECT_TRUE(reading(message).damped);
    } else {
      raw.send(Type::start, encode(start_of(robot_)));
      EXPECT_THAT(refused(raw.answer()), HasSubstr("damped: asked for by the driver: at once"));
    }
    EXPECT_THAT(complaint([&] { (void)remote(served); }), HasSubstr("(damped)"));
  }
}

TEST_P(RobotServerTest, ConnectionsThatSayNothingKeepNobodyAway) {
  Served served(robot_, {}, "secret");
  std::vector<std::unique_ptr<Raw>> silent;
  for (int k = 0; k < 100; ++k)
    silent.push_back(std::make_unique<Raw>(served.address()));
  { (void)remote(served, "secret"); }
  for (int k = 0; k < 100; ++k)
    silent.push_back(std::make_unique<Raw>(served.address()));
  EXPECT_NO_THROW(damp(served.address(), "secret"));
  served.at_the_robot([](RobotServer& server) { EXPECT_EQ(server.state(), RobotServer::State::damped); });
}

TEST_P(RobotServerTest, ADriverThatFloodsItWithTargetsKeepsNobodyFromDamping) {
  Served served(robot_);
  Raw raw(served.address());
  start(raw);
  const Reading first = reading(raw.answer());
  const VecX zero = VecX::Zero(n_);
  std::string flood;
  for (std::uint64_t sequence = 0; sequence < 1500; ++sequence)
    flood += framed(Type::target, encode(Target{sequence, first.measurement.q, zero, zero}));
  raw.send(flood);
  damp(served.address(), "");
  served.at_the_robot([&](RobotServer&) {
    // Far from all of them were followed before.
    EXPECT_LT(served.truth().t, 1000 * robot_.profile().tick.period);
  });
}

TEST_P(RobotServerTest, NoBytesWhateverTheyAreKeepADriverAway) {
  Served served(robot_);
  std::mt19937_64 random(7);
  for (int run = 0; run < 300; ++run) {
    std::string bytes;
    switch (random() % 4) {
      case 0:
        for (std::size_t i = 0; i < random() % 200; ++i)
          bytes += static_cast<char>(random());
        break;
      case 1:
        bytes = framed(static_cast<Type>(1 + random() % 12), std::string(random() % 100, static_cast<char>(random())));
        break;
      case 2:
        bytes = framed(Type::hello, hello());
        bytes[random() % bytes.size()] = static_cast<char>(random());
        break;
      default:
        bytes = framed(Type::hello, hello()) + framed(Type::start, encode(start_of(robot_)));
        bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    try {
      Raw raw(served.address());
      raw.send(bytes);
      if (random() % 2 == 0) raw.send(framed(static_cast<Type>(1 + random() % 12), bytes));
    } catch (const LinkError&) {  // it may close while we still send
    }
  }
  // A driver that says no more is dropped only after its time for that: it has to be gone, not silent.
  std::string why = "?";
  for (int attempt = 0; attempt < 1000 && !why.empty(); ++attempt) {
    why = complaint([&] {
      Simulation simulation = remote(served);
      for (int tick = 0; tick < 20; ++tick)
        simulation.session().step(Command{});
      EXPECT_NEAR(simulation.truth().t, 20 * robot_.profile().tick.period, 1e-9);
    });
  }
  EXPECT_EQ(why, "");
}

/// A robot's end that says what it is told to.
class Puppet {
 public:
  explicit Puppet(const RobotModel& model) : model_(&model), listener_(Socket::listen({"127.0.0.1", 0})) {
    welcome.robot = "puppet";
    for (const Joint& joint : model.joints())
      welcome.joints.push_back(joint.name);
    welcome.period = model.profile().tick.period;
    Reading reading;
    const VecX q = stand(model, Pose{}, model.profile().stance.com_height).q.tail(model.nv() - 6);
    reading.measurement.q = q;
    reading.measurement.dq = VecX::Zero(q.size());
    first = reading;
  }
  /// Says all of it at once, to one driver; then it is silent until it is destroyed, or hangs up.
  std::string driven(const std::vector<std::string>& more, bool hangs_up = false) {
    std::string why;
    std::thread driver([&] {
      why = complaint([&] {
        RemoteRobot::Parameters parameters{{"127.0.0.1", listener_.port()}, ""};
        parameters.connecting = parameters.answering = silence;
        RemoteRobot remote(*model_, "flat", parameters);
        JointTarget target;
        target.q = first.measurement.q;
        target.dq = target.tau = target.ddq = VecX::Zero(target.q.size());
        for (int tick = 0; tick < 3; ++tick)
          remote.write(target);
      });
    });
    {
      std::optional<Socket> peer;
      while (!peer)
        peer = listener_.accept();
      std::string bytes = framed(Type::welcome, encode(welcome));
      for (const std::string& message : more)
        bytes += message;
      peer->send(bytes, kLinkPatience);
      if (hangs_up) peer.reset();
      driver.join();
    }
    return why;
  }
  [[nodiscard]] std::string measurement(std::uint64_t sequence) const {
    Reading reading = first;
    reading.sequence = sequence;
    return framed(Type::measurement, encode(reading));
  }

  Welcome welcome;
  Reading first;
  Socket::Time silence{kLinkPatience};

 private:
  const RobotModel* model_;
  Socket listener_;
};

TEST_P(RobotServerTest, ARobotThatIsNotTheOneExpectedIsNotDriven) {
  const auto puppet_with = [&](const std::function<void(Puppet&)>& change) {
    Puppet puppet(robot_);
    change(puppet);
    return puppet.driven({puppet.measurement(0)});
  };
  EXPECT_THAT(puppet_with([](Puppet& p) { std::swap(p.welcome.joints[0], p.welcome.joints[1]); }),
              HasSubstr("as joint 0: must be '" + robot_.joints()[0].name));
  EXPECT_THAT(puppet_with([](Puppet& p) { p.welcome.joints.pop_back(); }),
              HasSubstr("'" + robot_.joints().back().name + "' is missing"));
  EXPECT_THAT(puppet_with([](Puppet& p) { p.welcome.joints.emplace_back("tail"); }), HasSubstr("without 'tail'"));
  EXPECT_THAT(puppet_with([](Puppet& p) { p.welcome.period *= 2.0; }), HasSubstr("has a tick of"));
  EXPECT_THAT(puppet_with([](Puppet& p) { p.welcome.version = 9; }), HasSubstr("speaks version 9"));
  EXPECT_THAT(puppet_with([](Puppet& p) { p.welcome.world = "room"; }),
              HasSubstr("stands in 'room': must be --world room"));
}

TEST_P(RobotServerTest, ARobotWhoseLimitsAreNarrowerThanTheModelsIsNotDriven) {
  const auto puppet_with = [&](const std::function<void(JointLimits&, Eigen::Index)>& change, Eigen::Index joint) {
    Puppet puppet(robot_);
    puppet.welcome.limits = limits_of(robot_);
    change(*puppet.welcome.limits, joint);
    return puppet.driven({puppet.measurement(0), puppet.measurement(1), puppet.measurement(2), puppet.measurement(3)});
  };
  for (Eigen::Index j = 0; j < n_; j += 3) {
    const std::string of_it = " of " + robot_.joints()[static_cast<std::size_t>(j)].name + ", the model ";
    EXPECT_EQ(puppet_with([](JointLimits&, Eigen::Index) {}, j), "");
    EXPECT_EQ(puppet_with(
                  [](JointLimits& limits, Eigen::Index i) {
                    limits.lower[i] -= 0.1;
                    limits.upper[i] += 0.1;
                    limits.speed[i] *= 2.0;
                    limits.torque[i] *= 2.0;
                  },
                  j),
              "");
    EXPECT_THAT(puppet_with([](JointLimits& limits, Eigen::Index i) { limits.lower[i] += 0.1; }, j),
                HasSubstr(" as lowest angle" + of_it));
    EXPECT_THAT(puppet_with([](JointLimits& limits, Eigen::Index i) { limits.upper[i] -= 0.1; }, j),
                HasSubstr(" as highest angle" + of_it));
    EXPECT_THAT(puppet_with([](JointLimits& limits, Eigen::Index i) { limits.speed[i] *= 0.9; }, j),
                HasSubstr(" as no-load speed" + of_it));
    EXPECT_THAT(puppet_with([](JointLimits& limits, Eigen::Index i) { limits.torque[i] *= 0.9; }, j),
                HasSubstr(" as stall torque" + of_it));
  }
}

TEST_P(RobotServerTest, ARobotThatBreaksTheProtocolIsNoticed) {
  const auto said = [&](const std::function<std::vector<std::string>(const Puppet&)>& messages, bool hangs_up = false,
                        Socket::Time silence = kLinkPatience) {
    Puppet puppet(robot_);
    puppet.silence = silence;
    return puppet.driven(messages(puppet), hangs_up);
  };
  using Messages = std::vector<std::string>;
  EXPECT_EQ(said([](const Puppet& p) {
              return Messages{p.measurement(0), p.measurement(1), p.measurement(2), p.measurement(3)};
            }),
            "");
  EXPECT_THAT(said([](const Puppet& p) {
                return Messages{p.measurement(0), p.measurement(0)};
              }),
              HasSubstr("measurement 0 in place of 1"));  // twice
  EXPECT_THAT(said([](const Puppet& p) {
                return Messages{p.measurement(0), p.measurement(2)};
              }),
              HasSubstr("measurement 2 in place of 1"));  // one lost
  EXPECT_THAT(said([](const Puppet&) { return Messages{framed(Type::measurement, "short")}; }),
              HasSubstr("of 5 bytes: must be"));
  EXPECT_THAT(said([](const Puppet& p) {
                return Messages{p.measurement(0), framed(Type::hello, hello())};
              }),
              HasSubstr("in place of a measurement"));
  EXPECT_THAT(said([](const Puppet& p) {
                return Messages{p.measurement(0), "HTTP/1.1 400"};
              }),
              HasSubstr("is this a baton link?"));
  EXPECT_THAT(said([](const Puppet& p) { return Messages{p.measurement(0)}; }, true), HasSubstr("the other end"));
  EXPECT_THAT(said([](const Puppet& p) {
                return Messages{p.measurement(0), framed(Type::bye)};
              }),
              HasSubstr("has ended the connection"));
  EXPECT_THAT(said(
                  [](const Puppet& p) {
                    Messages chatter{p.measurement(0)};
                    chatter.resize(5000, framed(Type::rejected, encode_text("a jump")));
                    return chatter;
                  },
                  false, Socket::Time(30)),
              HasSubstr(" ms"));
  EXPECT_THAT(said([](const Puppet& p) { return Messages{p.measurement(0)}; }, false, Socket::Time(30)),
              HasSubstr("nothing from the robot for 30 ms"));
}

/// Passes bytes on between a driver and a robot, and spoils them once.
class Proxy {
 public:
  enum class Fault { flip, lose, repeat, cut };

  /// @param at bytes that pass before, of both directions together
  Proxy(Address to, Fault fault, std::size_t at, std::uint64_t seed)
      : listener_(Socket::listen({"127.0.0.1", 0})),
        to_(std::move(to)),
        fault_(fault),
        left_(at),
        random_(seed),
        thread_([this] { pass(); }) {}
  ~Proxy() {
    stop_ = true;
    thread_.join();
  }
  [[nodiscard]] Address address() const { return {"127.0.0.1", listener_.port()}; }

 private:
  void pass() {
    std::optional<Socket> driver;
    while (!driver && !stop_)
      driver = listener_.accept();
    if (!driver) return;
    Socket robot = Socket::connect(to_, kLinkPatience);
    try {
      while (!stop_ && !cut_) {
        move(*driver, robot);
        move(robot, *driver);
      }
    } catch (const LinkError&) {  // one of them has hung up
    }
  }
  void move(Socket& from, Socket& to) {
    std::string bytes;
    if (!from.receive(bytes, Socket::Time(0))) return;
    if (left_ < bytes.size()) {
      const std::size_t size = std::min<std::size_t>(1 + random_() % 9, bytes.size() - left_);
      switch (fault_) {
        case Fault::flip:
          bytes[left_] = static_cast<char>(bytes[left_] ^ static_cast<char>(1U << (random_() % 8)));
          break;
        case Fault::lose:
          bytes.erase(left_, size);
          break;
        case Fault::repeat:
          bytes.insert(left_, bytes.substr(left_, size));
          break;
        case Fault::cut:
          bytes.erase(left_);
          cut_ = true;
      }
      left_ = std::numeric_limits<std::size_t>::max();
    } else if (left_ != std::numeric_limits<std::size_t>::max()) {
      left_ -= bytes.size();
    }
    to.send(bytes, kLinkPatience);
  }

  Socket listener_;
  Address to_;
  Fault fault_;
  std::size_t left_;
  std::mt19937_64 random_;
  bool cut_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST_P(RobotServerTest, ASpoiledConnectionEndsTheRunWithAReasonAndFellsNobody) {
  const Plant plant = plant_of(true, nullptr, robot_, 3, 1.0);
  Served served(robot_, plant);
  std::mt19937_64 random(8);
  int ended = 0;
  int harmless = 0;
  for (int run = 0; run < 60; ++run) {
    const auto fault = static_cast<Proxy::Fault>(random() % 4);
    Proxy proxy(served.address(), fault, random() % 60'000, random());
    double lowest = std::numeric_limits<double>::infinity();
    const std::string why = complaint([&] {
      RemoteRobot::Parameters parameters{proxy.address(), ""};
      parameters.connecting = parameters.answering = Socket::Time(300);
      auto connected = std::make_unique<RemoteRobot>(robot_, "flat", parameters);
      Simulation simulation(robot_, served.world(), std::move(connected), Simulation::Parameters{});
      const double height = simulation.truth().q[2];
      Command command;
      command.axes[0] = 1.0;
      for (int tick = 0; tick < 60; ++tick) {
        simulation.session().step(command);
        if (fault != Proxy::Fault::flip) lowest = std::min(lowest, simulation.truth().q[2] / height);
      }
    });
    ended += why.empty() ? 0 : 1;
    harmless += why.empty() ? 1 : 0;
    EXPECT_TRUE(why.empty() || why.find("127.0.0.1") != std::string::npos) << why;
    EXPECT_TRUE(fault == Proxy::Fault::flip || lowest > 0.95) << run;
    served.at_the_robot([&](RobotServer& server) {
      EXPECT_NE(server.state(), RobotServer::State::damped);
      EXPECT_FALSE(served.truth().fallen);
      EXPECT_LT(served.truth().dq.cwiseAbs().maxCoeff(), 20.0);
    });
  }
  EXPECT_GT(ended, 20);
  EXPECT_GT(harmless, 0);
}

TEST(RemoteRobot, NobodyThereIsSaidWithTheAddress) {
  const int port = [] {
    const Socket free = Socket::listen({"127.0.0.1", 0});
    return free.port();
  }();
  const std::string why = complaint([&] {
    (void)RemoteRobot(test::robot("mighty"), "flat", RemoteRobot::Parameters{{"127.0.0.1", port}, ""});
  });
  EXPECT_THAT(why, HasSubstr("tcp://127.0.0.1:" + std::to_string(port)));
  EXPECT_THAT(why, HasSubstr("refused"));
}

}  // namespace
}  // namespace baton::link
