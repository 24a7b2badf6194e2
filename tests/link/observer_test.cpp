/// Who looks on at a robot sees all of it, and changes nothing.
#include "baton/link/observer.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <random>
#include <thread>

#include "baton/model/error.hpp"
#include "baton/proving/scenario.hpp"
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

std::string observing(const std::string& token = "") {
  return encode(Hello{kVersion, token, Role::observe});
}

class ObserverTest : public testing::TestWithParam<bool> {
 protected:
  const RobotModel& robot_ = test::robot("mighty");
  const Eigen::Index n_ = robot_.nv() - 6;
  const Plant plant_ = plant_of(true, nullptr, robot_, 5, 1.0);
  const bool navigates_ = GetParam();

  /// A run of a walk in lock-step, with somebody beside it.
  /// @param beside called before each tick
  [[nodiscard]] std::vector<VecX> walk(
      Served& served, int ticks, const std::function<void(int)>& beside = [](int) {}) const {
    RemoteRobot remote(robot_, "flat", RemoteRobot::Parameters{served.address(), ""});
    std::vector<VecX> way;
    Command forward;
    forward.axes[0] = 1.0;
    if (navigates_) {
      for (int tick = 0; tick < ticks; ++tick) {
        beside(tick);
        static_cast<void>(remote.guide(forward));
        way.push_back(remote.tick().target);
        way.push_back(remote.read().q);
      }
      return way;
    }
    Navigator navigator(robot_, served.world(),
                        stand(robot_, served.world().site("start"), robot_.profile().stance.com_height));
    DirectPlanning planning(robot_, served.world(), Modes{});
    for (int tick = 0; tick < ticks; ++tick) {
      beside(tick);
      const JointTarget& target = navigator.tick(remote.read(), forward);
      way.push_back(commanded(target));
      remote.write(target);
      way.push_back(remote.read().q);
      navigator.poll();
      if (const std::optional<Request> request = navigator.request()) {
        planning.post(*request);
        if (auto reply = planning.poll(navigator.now())) navigator.answer(std::move(reply->answer));
      }
    }
    return way;
  }
};

INSTANTIATE_TEST_SUITE_P(RobotsEnds, ObserverTest, testing::Bool(),
                         [](const auto& ends) { return ends.param ? "Navigates" : "FollowsTargets"; });

TEST_P(ObserverTest, ARunIsTheSameBitByBitWhoeverLooksOn) {
  constexpr int kTicks = 300;
  const std::vector<VecX> alone = [&] {
    Served served(robot_, plant_, "", Served::Pace::lock_step, navigates_);
    return walk(served, kTicks);
  }();
  Served served(robot_, plant_, "", Served::Pace::lock_step, navigates_);
  Observer observer(robot_, "flat", {.address = served.address()});
  const std::vector<VecX> watched = walk(served, kTicks);
  ASSERT_EQ(alone.size(), watched.size());
  for (std::size_t i = 0; i < alone.size(); ++i)
    ASSERT_EQ(alone[i], watched[i]) << i;
  // And it sees the whole of it.
  const std::uint64_t all = kTicks + (navigates_ ? 0U : 1U);
  double t = -1.0;
  for (std::uint64_t seen = 0; seen < all; ++seen) {
    const std::optional<Reading> reading = observer.next(kLinkPatience);
    ASSERT_TRUE(reading) << seen;
    EXPECT_EQ(reading->sequence, seen);
    EXPECT_GE(reading->measurement.t, t);
    t = reading->measurement.t;
  }
  EXPECT_FALSE(observer.next(Socket::Time(0)));
}

TEST_P(ObserverTest, OneThatSpeaksStallsOrVanishesChangesNothing) {
  constexpr int kTicks = 120;
  const std::vector<VecX> alone = [&] {
    Served served(robot_, plant_, "", Served::Pace::lock_step, navigates_);
    return walk(served, kTicks);
  }();
  Served served(robot_, plant_, "", Served::Pace::lock_step, navigates_);
  std::mt19937_64 random(11);
  std::vector<std::unique_ptr<Raw>> beside;
  const std::vector<VecX> disturbed = walk(served, kTicks, [&](int) {
    if (random() % 3 == 0) beside.clear();
    try {
      auto raw = std::make_unique<Raw>(served.address());
      raw->send(Type::hello, observing());
      std::string bytes;
      switch (random() % 4) {
        case 0:
          for (std::size_t i = 0; i < 200; ++i)
            bytes += static_cast<char>(random());
          break;
        case 1:
          bytes =
              framed(static_cast<Type>(1 + random() % 13), std::string(random() % 700, static_cast<char>(random())));
          break;
        case 2:
          bytes = framed(Type::target, std::string(8 + 24 * static_cast<std::size_t>(n_), '\0'));
          break;
        default:  // says nothing, and listens to nothing
          break;
      }
      raw->send(bytes);
      beside.push_back(std::move(raw));
    } catch (const LinkError&) {  // it was closed while it spoke
    }
  });
  ASSERT_EQ(alone.size(), disturbed.size());
  for (std::size_t i = 0; i < alone.size(); ++i)
    ASSERT_EQ(alone[i], disturbed[i]) << i;
}

TEST_P(ObserverTest, NothingThatItSendsMovesTheRobot) {
  Served served(robot_, {}, "", Served::Pace::lock_step, navigates_);
  const VecX zero = VecX::Zero(n_);
  for (const auto& [type, body] : std::vector<std::pair<Type, std::string>>{
           {Type::start, encode(start_of(robot_))},
           {Type::target, encode(Target{0, zero, zero, zero})},
           {Type::command, encode(StickPosition{})},
           {Type::arms, encode(released_arms(robot_))},
           {Type::damp, encode_text("at once")},
           {Type::hello, hello()},
       }) {
    Raw raw(served.address());
    raw.send(Type::hello, observing());
    const Message welcome = raw.answer();
    ASSERT_EQ(welcome.type, Type::welcome);
    EXPECT_EQ(decode_welcome(welcome.body).role, Role::observe);
    raw.send(type, body);
    EXPECT_THAT(refused(raw.answer()), HasSubstr("from an observer: it may send nothing but bye"));
    EXPECT_TRUE(raw.closed());
    served.at_the_robot([&](RobotServer& server) {
      EXPECT_EQ(server.state(), RobotServer::State::waiting);
      EXPECT_EQ(served.truth().t, 0.0);
    });
  }
}

TEST_P(ObserverTest, OneIsWelcomeWhoKnowsTheTokenAlsoWhileTheRobotIsDamped) {
  Served served(robot_, {}, "secret", Served::Pace::lock_step, navigates_);
  const auto observe = [&](const std::string& token) {
    return complaint([&] { Observer(robot_, "flat", {.address = served.address(), .token = token}); });
  };
  EXPECT_THAT(observe(""), HasSubstr("refused (token)"));
  EXPECT_THAT(observe("guess"), HasSubstr("refused (token)"));
  const Observer first(robot_, "flat", {.address = served.address(), .token = "secret"});
  EXPECT_THAT(observe("secret"), HasSubstr("refused (busy)"));
  Served other(robot_, {}, "", Served::Pace::lock_step, navigates_);
  damp(other.address(), "");
  EXPECT_EQ(complaint([&] { Observer(robot_, "flat", {.address = other.address()}); }), "");
  EXPECT_THAT(complaint([&] { Observer(robot_, "room", {.address = other.address()}); }),
              HasSubstr("stands in 'flat'"));
}

TEST_P(ObserverTest, InRealTimeItSeesARobotThatNobodyDrivesYet) {
  Served served(robot_, {}, "", Served::Pace::by_test, navigates_);
  Observer observer(robot_, "flat", {.address = served.address()});
  served.pass(15);
  for (std::uint64_t k = 0; k < 15; ++k) {
    const std::optional<Reading> reading = observer.next(kLinkPatience);
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading->sequence, k);
    EXPECT_EQ(reading->measurement.t, 0.0);  // a simulated robot that nobody drives stands still in time
  }
  served.at_the_robot([&](RobotServer&) { EXPECT_EQ(served.truth().t, 0.0); });
  RemoteRobot remote(robot_, "flat", RemoteRobot::Parameters{served.address(), ""});
  served.pass(10);
  double t = -1.0;
  while (t < 7.5 * robot_.profile().tick.period) {
    const std::optional<Reading> reading = observer.next(kLinkPatience);
    ASSERT_TRUE(reading);
    t = reading->measurement.t;
  }
}

TEST_P(ObserverTest, OneThatTakesNothingIsLeft) {
  Served served(robot_, {}, "", Served::Pace::by_test, navigates_);
  Raw deaf(served.address());
  deaf.send(Type::hello, observing());
  EXPECT_EQ(deaf.answer().type, Type::welcome);
  for (int k = 0; k < 2000 && served.log().find("observer lost") == std::string::npos; ++k)
    served.pass(15);
  EXPECT_THAT(served.log(), HasSubstr("observer lost: the other end takes nothing"));
  Observer next(robot_, "flat", {.address = served.address()});
  served.pass(1);
  EXPECT_TRUE(next.next(kLinkPatience));
}

TEST(Observer, ARobotThatSomebodyElseControlsTakesNoDriver) {
  const RobotModel& model = test::robot("mighty");
  const World world = World::load("flat");
  Simulation simulation(model, world, Simulation::On::sim, Simulation::Parameters{});
  RobotServer server(model, *simulation.simulated(),
                     {.listen = {"127.0.0.1", 0}, .real_time = true, .only_observed = true});
  std::atomic<bool> done{false};
  std::thread others([&] {
    EXPECT_THAT(complaint([&] {
                  RemoteRobot(model, "flat", RemoteRobot::Parameters{server.address(), ""});
                }),
                HasSubstr("somebody else controls this robot"));
    EXPECT_THAT(complaint([&] { damp(server.address(), ""); }), HasSubstr("somebody else controls this robot"));
    Observer observer(model, "flat", {.address = server.address()});
    EXPECT_TRUE(observer.next(kLinkPatience));
    done = true;
  });
  while (!done)
    server.serve(Socket::Time(1));
  others.join();
  EXPECT_EQ(server.state(), RobotServer::State::waiting);
}

TEST(Observer, ARobotThatDoesNotKnowOfObserversIsNotStarted) {
  const RobotModel& model = test::robot("mighty");
  Socket listener = Socket::listen({"127.0.0.1", 0});
  std::string why;
  std::thread observer([&] {
    why = complaint([&] { Observer(model, "flat", {.address = {"127.0.0.1", listener.port()}}); });
  });
  std::optional<Socket> peer;
  while (!peer)
    peer = listener.accept();
  Welcome welcome;
  welcome.robot = "old";
  for (const Joint& joint : model.joints())
    welcome.joints.push_back(joint.name);
  welcome.period = model.profile().tick.period;
  std::string body = encode(welcome);
  const std::string role = R"("role":"drive",)";
  body.erase(body.find(role), role.size());
  peer->send(framed(Type::welcome, body), kLinkPatience);
  observer.join();
  EXPECT_THAT(why, HasSubstr("does not know of observers"));
  Stream heard;
  try {
    while (peer->receive(heard.bytes(), kLinkPatience)) {
    }
  } catch (const LinkError&) {
  }
  std::vector<Type> types;
  while (const std::optional<Message> message = heard.next())
    types.push_back(message->type);
  EXPECT_EQ(types, (std::vector<Type>{Type::hello, Type::bye}));
}

}  // namespace
}  // namespace baton::link
