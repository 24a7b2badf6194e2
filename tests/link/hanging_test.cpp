#include "baton/link/hanging.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <random>

#include "baton/ik/stand.hpp"
#include "baton/link/engage.hpp"
#include "baton/link/target_check.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/stick.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "baton/run/session.hpp"
#include "tests/support/robots.hpp"

namespace baton::link {
namespace {

class HangingTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
  const double height_ = robot_.profile().stance.com_height;
  const double period_ = robot_.profile().tick.period;
  const Posture stance_ = stand(robot_, Pose{}, height_);

  /// Joint angles as of one that hangs limp, more or less.
  [[nodiscard]] VecX limp(std::mt19937_64& random) const {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    VecX q = stance_.q.tail(n_);
    const double straight = share(random);
    for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
      const Range& range = robot_.joints()[j].position;
      double& angle = q[static_cast<Eigen::Index>(j)];
      angle = std::clamp((1.0 - straight) * angle + 0.1 * (share(random) - 0.5), range.lo, range.hi);
    }
    return q;
  }
  /// The way from there, if there is one.
  [[nodiscard]] std::optional<WayToStance> way_from(const VecX& q) const {
    try {
      return WayToStance(robot_, q);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("move them apart"));
      return std::nullopt;
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, HangingTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(HangingTest, TheWayIsSmoothSlowAndEndsInTheStance) {
  std::mt19937_64 random(1);
  int found = 0;
  for (int run = 0; run < 100; ++run) {
    const VecX q = limp(random);
    std::optional<WayToStance> way = way_from(q);
    if (!way) continue;
    ++found;
    JointTarget before{q, VecX::Zero(n_), VecX::Zero(n_), VecX::Zero(n_), {true, true}, {}};
    Kinematics kinematics(robot_);
    VecX whole = stance_.q;
    whole.tail(n_) = q;
    kinematics.set(whole);
    const double margin = robot_.profile().margin.self_collision;
    const double first = std::min(kinematics.self_distance(margin), margin);
    while (!way->done()) {
      const JointTarget next = way->next();
      ASSERT_LE((next.q - before.q).cwiseAbs().maxCoeff(), 1.001 * WayToStance::kFastest * period_);
      ASSERT_LE((next.dq - before.dq).cwiseAbs().maxCoeff(), 2.0 * period_) << "[rad/s] in a tick";
      ASSERT_LE((next.q - before.q - 0.5 * period_ * (next.dq + before.dq)).cwiseAbs().maxCoeff(), 1e-5);
      whole.tail(n_) = next.q;
      kinematics.set(whole);
      ASSERT_GE(kinematics.self_distance(margin), first < margin ? first - 0.011 * height_ : margin - 1e-3);
      before = next;
    }
    EXPECT_LT((before.q - stance_.q.tail(n_)).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT(before.dq.cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(way->next().q, before.q) << "and stays there";
  }
  EXPECT_GT(found, 60);
}

// In physics, on the plant `real`: taken to its stance in the air, lowered, left to itself, and guided.
TEST_P(HangingTest, IsLoweredStandsAndIsGuided) {
  const World world = World::load("flat");
  std::mt19937_64 random(2);
  int tried = 0;
  for (std::uint64_t seed = 0; tried < 4; ++seed) {
    Posture start = stand(robot_, world.site("start"), height_);
    const Posture standing = start;
    start.q.tail(n_) = limp(random);
    start.q[2] += 0.3 * height_;
    SimulatedRobot simulated(robot_, world, start, period_, {.plant = real_plant(robot_, 260 + seed), .hangs = true});
    std::optional<WayToStance> way = way_from(simulated.read().q);
    if (!way) continue;
    ++tried;
    double fastest = 0.0;
    const auto watch = [&](double after) {
      if (simulated.truth()->t > after)
        fastest = std::max(fastest, simulated.truth()->dq.tail(n_).cwiseAbs().maxCoeff());
      ASSERT_FALSE(simulated.truth()->fallen) << "seed " << seed << ": " << simulated.truth()->fall;
    };
    while (!way->done()) {
      simulated.write(way->next());
      watch(0.5);  // the robot was let go of with limp joints: they swing
    }
    EXPECT_TRUE(in_stance(robot_, simulated.read().q));

    Session session(robot_, world, simulated, standing,
                    {.source = seed % 2 == 0 ? StateSource::sensors : StateSource::torques, .hangs = true});
    const auto ticks = [&](double time) { return std::lround(time / period_); };
    Command ahead{.guide = Part::trunk};
    ahead.axes.x() = 1.0;
    for (long k = 0; k < ticks(1.5); ++k) {
      session.step(ahead);  // of somebody who cannot wait
      watch(0.0);
      ASSERT_TRUE(session.resting()) << "seed " << seed;
    }
    EXPECT_EQ(session.navigator().guard(), Guard::lifted);
    EXPECT_LT(fastest, 0.5) << "seed " << seed << " [rad/s]";
    simulated.move_gantry(-0.6 * height_);
    long lowered = 0;
    while (session.navigator().guard() == Guard::lifted && ++lowered < ticks(20.0)) {
      session.step({});
      watch(1e9);
    }
    ASSERT_EQ(session.navigator().guard(), Guard::armed) << "seed " << seed;
    for (long k = 0; k < ticks(4.0); ++k) {
      session.step({});
      watch(1e9);
    }
    EXPECT_TRUE(session.resting());
    const Vec3 before = session.navigator().state().com;
    ahead.axes.x() = 0.0;
    ahead.axes.z() = -1.0;  // down, as every robot can
    for (long k = 0; k < ticks(4.0); ++k) {
      session.step(ahead);
      watch(1e9);
    }
    EXPECT_LT(session.navigator().state().com.z(), before.z() - 0.01 * height_) << "seed " << seed;
  }
}

// Whoever lifts it again finds it as it was: nothing is begun in the air.
TEST_P(HangingTest, IsLiftedOutOfAWalkAndSetDownAgain) {
  const World world = World::load("flat");
  const Posture start = stand(robot_, world.site("start"), height_);
  SimulatedRobot simulated(robot_, world, start, period_, {.plant = real_plant(robot_, 270), .hangs = true});
  simulated.move_gantry(-0.1 * height_);
  Session session(robot_, world, simulated, start, {.hangs = true});
  Stick stick(7, period_);
  double highest = 0.0;
  for (long k = 0; k < std::lround(30.0 / period_); ++k) {
    const double t = static_cast<double>(k) * period_;
    simulated.move_gantry((t > 6.0 && t < 14.0 ? 0.3 : -0.15) * height_);
    session.step(t < 20.0 ? stick.next() : Command{});
    highest = std::max(highest, simulated.truth()->q[2]);
    ASSERT_FALSE(simulated.truth()->fallen) << t << " s: " << simulated.truth()->fall;
    if (session.navigator().guard() == Guard::lifted) {
      ASSERT_EQ(find_event<Committed>(session.navigator().events()), nullptr) << t << " s";
    }
  }
  EXPECT_GT(highest, start.q[2] + 0.15 * height_);
  EXPECT_EQ(session.navigator().guard(), Guard::armed);
  EXPECT_TRUE(session.resting());
}

// However long it hangs, its position does not drift, so that nothing jumps when it lands: a robot's end would refuse.
TEST_P(HangingTest, HangsForLongAndLandsWithoutAJump) {
  const World world = World::load("flat");
  for (const std::uint64_t seed : {1U, 2U}) {
    Posture start = stand(robot_, world.site("start"), height_);
    const Posture standing = start;
    start.q[2] += 0.2 * height_;
    SimulatedRobot simulated(robot_, world, start, period_, {.plant = real_plant(robot_, 280 + seed), .hangs = true});
    Session session(robot_, world, simulated, standing,
                    {.source = seed == 1 ? StateSource::sensors : StateSource::torques, .hangs = true});
    TargetCheck check(robot_);
    std::string rejected;
    Hooks hooks;
    hooks.tick = [&](const TickRecord& record) {
      if (record.t == 0.0) check.begin(commanded(record.target));
      const auto why =
          check.reject({0, commanded(record.target), record.target.dq, record.target.tau}, record.measurement.q);
      if (why && rejected.empty()) rejected = *why;
    };
    session.add(hooks);
    for (long k = 0; k < std::lround(40.0 / period_); ++k) {
      if (static_cast<double>(k) * period_ > 30.0) simulated.move_gantry(-0.4 * height_);
      session.step({});
      ASSERT_FALSE(simulated.truth()->fallen) << "seed " << seed << ": " << simulated.truth()->fall;
    }
    EXPECT_EQ(rejected, "") << "seed " << seed;
    EXPECT_EQ(session.navigator().guard(), Guard::armed) << "seed " << seed;
    EXPECT_LT((session.navigator().state().q.head<2>() - standing.q.head<2>()).norm(), 0.5 * height_);
  }
}

// By a plan in place of what is not measured, a robot stands wherever it is.
TEST_P(HangingTest, WithoutASensorOfItsLoadItDoesNotStand) {
  const World world = World::load("flat");
  Posture start = stand(robot_, world.site("start"), height_);
  const Posture standing = start;
  start.q[2] += 0.2 * height_;
  class Numb : public SimulatedRobot {
   public:
    using SimulatedRobot::SimulatedRobot;
    [[nodiscard]] Measurement read() override {
      Measurement measurement = SimulatedRobot::read();
      measurement.sole.right.force.setConstant(std::numeric_limits<double>::quiet_NaN());
      return measurement;
    }
  };
  Numb simulated(robot_, world, start, period_, {.plant = real_plant(robot_, 290), .hangs = true});
  Session session(robot_, world, simulated, standing, {.hangs = true});
  for (long k = 0; k < std::lround(4.0 / period_); ++k) {
    session.step({});
    ASSERT_EQ(session.navigator().guard(), Guard::lifted);
  }
}

TEST(WayToStanceTest, NamesWhatIsInTheWay) {
  const RobotModel& robot = test::robot("mighty");
  VecX q = stand(robot, Pose{}, robot.profile().stance.com_height).q.tail(robot.nv() - 6);
  q[0] = 9.0;
  try {
    const WayToStance way(robot, q);
    FAIL() << "a joint that cannot be there";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(robot.joints()[0].name));
    EXPECT_THAT(error.what(), testing::HasSubstr("9.000"));
  }
}

}  // namespace
}  // namespace baton::link
