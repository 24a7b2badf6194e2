#include "baton/link/follow_check.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <random>
#include <thread>

#include "baton/ik/stand.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/proving/stick.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/served.hpp"

namespace baton::link {
namespace {

using testing::HasSubstr;

class FollowCheckTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
  const double period_ = robot_.profile().tick.period;
  const World world_ = World::load("flat");
};

class FollowCheckRunsTest : public FollowCheckTest {};

INSTANTIATE_TEST_SUITE_P(Robots, FollowCheckTest, testing::ValuesIn(test::robot_names()), test::name_of_param);
INSTANTIATE_TEST_SUITE_P(Robots, FollowCheckRunsTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

// Pushed about, and with twice the share that is asked for: nothing that a driven robot does looks like that.
TEST_P(FollowCheckRunsTest, ARobotThatIsDrivenIsNeverTakenForOneThatDoesNotFollow) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Simulation::Parameters parameters;
    parameters.physics.plant = real_plant(robot_, seed);
    Simulation simulation(robot_, world_, Simulation::On::sim, parameters);
    Session& session = simulation.session();
    FollowCheck check(robot_, {.share = 0.2});
    VecX before;
    std::string why;
    int moved = 0;
    Hooks hooks;
    hooks.tick = [&](const TickRecord& record) {
      if (before.size() > 0) check.take(before, record.measurement.q);
      if (why.empty() && !check.why().empty()) why = fmt::format("{:.3f} s: {}", record.t, check.why());
      before = commanded(record.target);
      moved += record.target.dq.norm() > 1.0 ? 1 : 0;
    };
    session.add(hooks);
    const std::unique_ptr<Device> stick = stick_of(scenario_named("real"), robot_, seed);
    for (long tick = 0; session.t() < 15.0 && !session.fallen(); ++tick) {
      const double angle = static_cast<double>(tick);
      if (tick % 600 == 300)
        simulation.simulated()->push(0.25 * robot_.mass() * Vec3(std::cos(angle), std::sin(angle), 0.0));
      session.step(stick->read(session.t()));
    }
    EXPECT_EQ(why, "") << seed;
    EXPECT_GT(moved, 100);
  }
}

/// A robot whose emergency stop is pressed at some time: its joints stay where they are then, and their encoders go on.
class Stopped : public Robot {
 public:
  Stopped(const RobotModel& model, const World& world, double at, std::uint64_t seed)
      : robot_(model, world, stand(model, world.site("start"), model.profile().stance.com_height),
               model.profile().tick.period),
        at_(at),
        random_(seed) {}

  Measurement read() override {
    Measurement measured = robot_.read();
    if (measured.t < at_) {
      q_ = measured.q;
      return measured;
    }
    std::normal_distribution<double> noise(0.0, 3e-4);
    measured.q = q_.unaryExpr([&](double q) { return q + noise(random_); });
    measured.dq = q_.unaryExpr([&](double) { return 10.0 * noise(random_); });
    return measured;
  }
  void write(const JointTarget& target) override { robot_.write(target); }
  void reset() override { robot_.reset(); }
  const Truth* truth() const override { return robot_.truth(); }

 private:
  SimulatedRobot robot_;
  double at_;
  std::mt19937_64 random_;
  VecX q_;
};

TEST_P(FollowCheckTest, AnArmThatIsHeldIsNoReason) {
  FollowCheck check(robot_);
  VecX q = stand(robot_, Pose{}, robot_.profile().stance.com_height).q.tail(n_);
  const VecX held = q;
  for (int k = 0; k < 100; ++k) {
    for (const int j : robot_.arm(Side::left))
      q[j] += 0.01;
    check.take(q, held);
    EXPECT_EQ(check.why(), "");
  }
  q[robot_.leg(Side::left)[2]] += 0.01;
  for (int k = 0; k < 40; ++k) {
    q[robot_.leg(Side::left)[2]] += 0.01;
    check.take(q, held);
  }
  EXPECT_THAT(check.why(), HasSubstr(robot_.joints()[static_cast<std::size_t>(robot_.leg(Side::left)[2])].name));
  check.begin();
  EXPECT_EQ(check.why(), "");
}

// A driver that was stopped for a while answers what has come meanwhile, one by one.
TEST_P(FollowCheckTest, ADriverThatIsBehindBlamesItselfUntilItHasCaughtUp) {
  test::Served served(robot_, {}, "", test::Served::Pace::by_answers);
  RemoteRobot::Parameters parameters{served.address(), ""};
  std::chrono::steady_clock::time_point now;
  parameters.now = [&] { return now; };
  RemoteRobot remote(robot_, "flat", parameters);
  const VecX stance = stand(robot_, Pose{}, robot_.profile().stance.com_height).q.tail(n_);
  const VecX zero = VecX::Zero(n_);
  const auto tick =
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(period_));
  const auto live = [&](int ticks, std::chrono::steady_clock::duration passes) {
    for (int k = 0; k < ticks; ++k) {
      now += passes;
      remote.write({stance, zero, zero, zero, {true, true}, zero});
    }
  };
  live(40, tick);
  EXPECT_NEAR(remote.late(), 0.0, 1e-3);
  now += 60 * tick;
  live(1, tick);
  EXPECT_NEAR(remote.late(), 60 * period_, 2e-3);
  live(60, std::chrono::steady_clock::duration::zero());
  EXPECT_NEAR(remote.late(), 0.0, 2e-3);
  now += 60 * tick;  // the robot has left time out
  live(1, tick);
  EXPECT_GT(remote.late(), 0.1);
  live(static_cast<int>(3.0 / period_), tick);
  EXPECT_LT(remote.late(), 0.1);
  EXPECT_EQ(remote.follows_no_longer(), "");
}

TEST_P(FollowCheckRunsTest, AnEmergencyStopAtTheRobotIsNoticedWithinATenthOfASecondOfMoving) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const double at = 2.0 + 0.23 * static_cast<double>(seed);
    Stopped stopped(robot_, world_, at, seed);
    RobotServer server(robot_, stopped, {.listen = {"127.0.0.1", 0}, .world = "flat"});
    const Address address = server.address();
    std::atomic<bool> stop{false};
    std::thread thread([&] {
      while (!stop)
        server.serve(Socket::Time(1));
    });
    {
      auto connected = std::make_unique<RemoteRobot>(robot_, "flat", RemoteRobot::Parameters{address, ""});
      RemoteRobot* const remote = connected.get();
      Simulation simulation(robot_, world_, std::move(connected), Simulation::Parameters{});
      Session& session = simulation.session();
      double moves = 0.0;  // time for which it has been told to move since then
      Hooks hooks;
      hooks.tick = [&](const TickRecord& record) {
        if (record.t > at && record.target.dq.norm() > 0.6) moves += period_;
      };
      session.add(hooks);
      Command ahead;
      ahead.axes[0] = 1.0;
      while (session.t() < at + 3.0 && remote->follows_no_longer().empty())
        session.step(ahead);
      EXPECT_THAT(remote->follows_no_longer(), HasSubstr("the robot does not follow: "));
      EXPECT_THAT(remote->follows_no_longer(), HasSubstr(" was told to go by "));
      EXPECT_GT(session.t(), at);
      EXPECT_LE(moves, 0.1 + 2 * period_) << at;
    }
    stop = true;
    thread.join();
  }
}

}  // namespace
}  // namespace baton::link
