/// Arms that are driven from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "baton/model/error.hpp"
#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Trip;

class ArmsTest : public testing::TestWithParam<const char*> {
 protected:
  /// Names of the joints of both arms.
  [[nodiscard]] std::vector<std::string> joints() const { return released_arms(robot_).joints; }
  [[nodiscard]] VecX home() const {
    VecX q(static_cast<Eigen::Index>(joints().size()));
    Eigen::Index k = 0;
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side))
        q[k++] = robot_.joints()[static_cast<std::size_t>(j)].home;
    }
    return q;
  }
  /// Largest distance of a joint that is driven from where it is to be.
  [[nodiscard]] double off(const Trip& trip) const {
    double most = 0.0;
    for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
      const ArmTrajectory& arms = trip.navigator().arms();
      if (!arms.drives(static_cast<int>(j))) continue;
      const double t = static_cast<double>(trip.navigator().now()) * period_;
      const double q = trip.navigator().sample().q[7 + static_cast<Eigen::Index>(j)];
      most = std::max(most, std::abs(arms.at(static_cast<int>(j), t) - q));
    }
    return most;
  }
  [[nodiscard]] int ticks(double t) const { return static_cast<int>(std::lround(t / period_)); }

  const RobotModel& robot_ = test::robot(GetParam());
  const double period_ = robot_.profile().tick.period;
};

INSTANTIATE_TEST_SUITE_P(Robots, ArmsTest, testing::Values("mighty", "scaled"),
                         [](const auto& robot) { return std::string(robot.param); });

TEST_P(ArmsTest, AtRestTheyComeToTheirTargetAndStay) {
  Trip trip(robot_);
  trip.step({});
  const VecX q = home() + VecX::Constant(home().size(), 0.2);
  trip.navigator().drive_arms({joints(), {0.1}, q.transpose()});
  for (int k = 0; k < ticks(2.5); ++k)
    trip.step({});
  EXPECT_LT(off(trip), 0.012);
  EXPECT_EQ(trip.navigator().motion(), nullptr);
  const long committed = trip.navigator().committed();
  for (int k = 0; k < ticks(2.0); ++k)
    trip.step({});
  EXPECT_EQ(trip.navigator().committed(), committed);
}

TEST_P(ArmsTest, WhatIsKnownAheadIsFollowedWhileTheRobotWalks) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Trip trip(robot_);
  Command ahead;
  ahead.axes[0] = 1.0;
  int on_target = 0;
  int all = 0;
  VecX from = home();
  const double chunk = 1.5;
  VecX to = from;
  Posture before = trip.posture();
  for (int k = 0; k < ticks(30.0); ++k) {
    if (k % ticks(chunk) == 0) {  // known a second ahead and more
      from = to;
      to = home();
      for (double& angle : to)
        angle += 0.2 * uniform(random);
      const double t = k * period_ + chunk;
      ArmTargets targets{joints(), {}, MatX(11, to.size())};
      for (int i = 0; i <= 10; ++i) {
        const double s = 0.1 * i;
        targets.t.push_back(t + chunk * s);
        targets.q.row(i) = (from + s * s * s * (10.0 + s * (-15.0 + 6.0 * s)) * (to - from)).transpose();
      }
      trip.navigator().drive_arms(targets);
    }
    trip.step(ahead);
    const double o = off(trip);
    ++all;
    if (o < 0.05) ++on_target;
  }
  EXPECT_GT(on_target, 0.9 * all);
  EXPECT_GT((trip.posture().com - before.com).norm(), 3.0 * robot_.profile().stance.com_height);
}

TEST_P(ArmsTest, AStreamThatIsSaidAgainAndAgainDoesNotHoldUpTheStick) {
  const double omega = 2.0 * 3.14159 * 0.5;
  Command trunk;
  trunk.axes[0] = 0.8;
  Command turn;
  turn.axes[5] = 0.8;
  Command foot{.guide = Part::left_foot};
  foot.axes[0] = 0.8;
  Command lift{.guide = Part::right_foot};
  lift.lift.right = 0.6;
  Command reach{.guide = Part::left_hand};
  reach.axes[2] = 0.6;
  for (const Command& command : {trunk, turn, foot, lift, reach}) {
    std::array<double, 4> way{};
    for (std::size_t stream = 0; stream < way.size(); ++stream) {
      Trip trip(robot_);
      const Posture start = trip.posture();
      for (int k = 0; k < ticks(6.0); ++k) {
        const double t = k * period_;
        const double every = std::array{0.0, 0.02, 0.1, 0.1}[stream];
        if (stream > 0 && k % ticks(every) == 0) {
          ArmTargets targets{joints(), {}, MatX(stream == 3 ? 1 : 20, home().size())};
          for (int i = 0; i < targets.q.rows(); ++i) {
            targets.t.push_back(t + 0.05 * i);
            targets.q.row(i) = (home().array() + 0.15 * std::sin(omega * targets.t.back())).transpose();
          }
          trip.navigator().drive_arms(targets);
        }
        trip.step(command);
      }
      const Posture end = trip.posture();
      const Part part = command.guide;
      way[stream] = is_foot(part)   ? (end.sole[side_of(part)].p - start.sole[side_of(part)].p).norm()
                    : is_hand(part) ? (end.hand[side_of(part)].p - start.hand[side_of(part)].p).norm()
                                    : (end.com - start.com).norm() + 0.3 * std::abs(end.heading() - start.heading());
      // A robot that reaches needs both arms; what is planned for one may wait for the other.
      EXPECT_GT(way[stream], (is_hand(part) ? 0.5 : 0.7) * way[0])
          << to_string(command.guide) << ' ' << command.axes.transpose() << ": " << stream;
    }
    EXPECT_GT(way[0], 0.015);
  }
}

TEST_P(ArmsTest, AHandThatWasGuidedGoesBackToItsTargets) {
  Trip trip(robot_);
  trip.step({});
  const VecX q = home() + VecX::Constant(home().size(), 0.15);
  trip.navigator().drive_arms({joints(), {0.1}, q.transpose()});
  Command reach{.guide = Part::left_hand};
  reach.axes[2] = 1.0;
  for (int k = 0; k < ticks(3.0); ++k)
    trip.step(reach);
  EXPECT_GT(off(trip), 0.05);
  for (int k = 0; k < ticks(4.0); ++k)
    trip.step({.guide = Part::left_hand});
  EXPECT_LT(off(trip), 0.012);
  EXPECT_EQ(trip.navigator().motion(), nullptr);
}

TEST_P(ArmsTest, TheyFollowWhileAFootIsUp) {
  Trip trip(robot_);
  Command lift{.guide = Part::right_foot};
  lift.lift.right = 0.6;
  for (int k = 0; k < ticks(4.0); ++k)
    trip.step(lift);
  ASSERT_FALSE(trip.navigator().sample().contact.right);
  const VecX q = home() + VecX::Constant(home().size(), 0.1);
  trip.navigator().drive_arms({joints(), {0.1}, q.transpose()});
  for (int k = 0; k < ticks(3.0); ++k)
    trip.step(lift);
  EXPECT_LT(off(trip), 0.012);
  EXPECT_FALSE(trip.navigator().sample().contact.right);
}

TEST_P(ArmsTest, WhatIsLetGoOfComesToRestWhereItIs) {
  const int elbow = robot_.arm(Side::left).back();
  for (const bool all : {true, false}) {
    Trip trip(robot_);
    trip.step({});
    const VecX q = home() + VecX::Constant(home().size(), -0.4);
    trip.navigator().drive_arms({joints(), {1.0}, q.transpose()});
    double before = 0.0;
    for (int k = 0; k < ticks(0.6); ++k) {
      before = trip.navigator().sample().q[7 + elbow];
      trip.step({});
    }
    const double now = trip.navigator().sample().q[7 + elbow];
    ASSERT_LT(now, before - 0.1 * period_);
    ArmTargets none = released_arms(robot_);
    if (!all) none.joints = {robot_.joints()[static_cast<std::size_t>(elbow)].name};
    trip.navigator().drive_arms(none);
    for (int k = 0; k < ticks(2.0); ++k)
      trip.step({});
    EXPECT_NEAR(trip.navigator().sample().q[7 + elbow], now, 0.15);
    EXPECT_EQ(trip.navigator().motion(), nullptr);
  }
}

TEST_P(ArmsTest, EachOfWhatIsRefusedIsAnEvent) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Trip trip(robot_);
  trip.step({});
  // Angles at which an arm is inside another link.
  Kinematics kinematics(robot_);
  const auto impossible = [&] {
    VecX q = trip.home().q;
    VecX angles(home().size());
    do {
      Eigen::Index k = 0;
      for (const Side side : kSides) {
        for (const int j : robot_.arm(side)) {
          const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
          q[7 + j] = angles[k++] = range.lo + uniform(random) * (range.hi - range.lo);
        }
      }
      kinematics.set(q);
    } while (kinematics.self_distance(0.0) > -0.01 * robot_.profile().stance.com_height);
    return angles;
  };
  for (int trial = 0; trial < 3; ++trial) {
    const VecX q = impossible();
    trip.navigator().drive_arms({joints(), {trip.navigator().now() * period_ + 0.5}, q.transpose()});
    EXPECT_EQ(trip.navigator().arms_refusal(), nullptr);
    int refused = 0;
    for (int k = 0; k < ticks(4.0); ++k) {
      trip.step({});
      if (find_event<ArmsRefused>(trip.navigator().events()) == nullptr) continue;
      ++refused;
      ASSERT_NE(trip.navigator().arms_refusal(), nullptr);
    }
    EXPECT_GE(refused, 1) << trial;
    EXPECT_LE(refused, 3) << trial;
  }
  trip.navigator().drive_arms(released_arms(robot_));
  EXPECT_EQ(trip.navigator().arms_refusal(), nullptr);
}

TEST_P(ArmsTest, ATrajectoryIsWhatWasSaidLastFromItsFirstTimeOn) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const int joint = robot_.arm(Side::left).front();
  const std::string name = robot_.joints()[static_cast<std::size_t>(joint)].name;
  const double mid = robot_.joints()[static_cast<std::size_t>(joint)].home;
  const VecX q = VecX::Constant(robot_.nv() - 6, mid);
  for (int trial = 0; trial < 2000; ++trial) {
    const double now = 10.0 * uniform(random);
    const auto draw = [&](double first) {
      ArmTargets targets{{name}, {}, MatX(1 + static_cast<Eigen::Index>(random() % 6), 1)};
      double t = first;
      for (Eigen::Index i = 0; i < targets.q.rows(); ++i) {
        targets.t.push_back(t);
        targets.q(i, 0) = mid + 0.1 * uniform(random);
        t += 0.05 + uniform(random);
      }
      return targets;
    };
    const ArmTargets first = draw(now + 2.0 * uniform(random) - 1.0);
    const ArmTrajectory one = ArmTrajectory(robot_).continued(first, now, q);
    const ArmTrajectory both = one.continued(draw(now + 1.0 + uniform(random)), now + 0.5, q);
    for (int k = 0; k < 20; ++k) {
      // Where a target was said, it is; from target to target evenly, those before now included.
      const double t = now + 6.0 * uniform(random);
      const auto after = std::ranges::upper_bound(first.t, t);
      if (after == first.t.begin()) continue;
      const auto i = static_cast<Eigen::Index>(after - first.t.begin()) - 1;
      double expected = first.q(i, 0);
      if (after != first.t.end())
        expected += (t - *std::prev(after)) / (*after - *std::prev(after)) * (first.q(i + 1, 0) - first.q(i, 0));
      ASSERT_NEAR(one.at(joint, t), expected, 1e-9) << now << ' ' << t;
    }
    ASSERT_NEAR(both.at(joint, now + 0.5), one.at(joint, now + 0.5), 1e-9);
  }
}

TEST_P(ArmsTest, WhatTheyDidIsRetraced) {
  Trip trip(robot_);
  trip.step({});
  const VecX start = trip.navigator().sample().q;
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (int k = 0; k < ticks(6.0); ++k) {
    if (k % ticks(0.3) == 0) {
      VecX q = home();
      for (double& angle : q)
        angle += uniform(random);
      trip.navigator().drive_arms({joints(), {k * period_ + 0.3}, q.transpose()});
    }
    trip.step({});
  }
  trip.navigator().drive_arms(released_arms(robot_));
  for (int k = 0; k < ticks(2.0); ++k)
    trip.step({});
  ASSERT_EQ(trip.navigator().motion(), nullptr);
  EXPECT_GT((trip.navigator().sample().q - start).norm(), 0.1);
  Command back;
  back.recall = Recall::retrace;
  for (int k = 0; k < ticks(60.0) && trip.navigator().history() + (trip.navigator().motion() != nullptr) > 0; ++k)
    trip.step(back);
  EXPECT_LT((trip.navigator().sample().q - start).tail(robot_.nv() - 6).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_P(ArmsTest, NothingThatDrivesThemBreaksThePlan) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 3; ++trial) {
    Trip trip(robot_);
    Command command;
    VecX q_before;
    for (int k = 0; k < ticks(20.0); ++k) {
      if (random() % 100 == 0) {
        command.guide = kParts[random() % kParts.size()];
        for (double& axis : command.axes)
          axis = random() % 3 == 0 ? 0.0 : uniform(random);
        command.lift = {random() % 4 == 0 ? 0.6 : 0.0, random() % 4 == 0 ? 0.6 : 0.0};
        command.recall = random() % 6 == 0 ? static_cast<Recall>(random() % 4) : Recall::none;
      }
      if (random() % 60 == 0) {
        ArmTargets targets;
        for (const std::string& joint : joints()) {
          if (random() % 3 != 0) targets.joints.push_back(joint);
        }
        double t = k * period_ + uniform(random);
        for (std::size_t n = random() % 6; n > 0; --n) {
          t += 0.01 + 0.5 * std::abs(uniform(random));
          targets.t.push_back(t);
        }
        targets.q = MatX(static_cast<Eigen::Index>(targets.t.size()), static_cast<Eigen::Index>(targets.joints.size()));
        for (Eigen::Index i = 0; i < targets.q.rows(); ++i) {
          for (Eigen::Index j = 0; j < targets.q.cols(); ++j)
            targets.q(i, j) = 6.0 * uniform(random);
        }
        trip.navigator().drive_arms(targets);
      }
      const VecX q = trip.step(command).q;
      ASSERT_TRUE(q.allFinite());
      if (k > 0) {
        for (Eigen::Index j = 0; j < q.size(); ++j) {
          const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
          ASSERT_LE(std::abs(q[j] - q_before[j]), 1.01 * joint.speed * period_) << joint.name << " at " << k;
          ASSERT_GE(std::min(q[j] - joint.position.lo, joint.position.hi - q[j]), 0.0);
        }
      }
      q_before = q;
      ASSERT_EQ(trip.navigator().guard(), Guard::armed);
    }
    const long committed = trip.navigator().committed();
    EXPECT_GT(committed, 20);
  }
}

TEST_P(ArmsTest, WhatTheyCannotReachIsRefusedAndTheStickStillServes) {
  Trip trip(robot_);
  trip.step({});
  std::mt19937_64 random(3);
  // Both hands into the trunk: somewhere on the way they come too close.
  VecX q = home();
  for (double& angle : q)
    angle += 3.0;
  trip.navigator().drive_arms({joints(), {0.5}, q.transpose()});
  for (int k = 0; k < ticks(4.0); ++k)
    trip.step({});
  const Vec3 before = trip.posture().com;
  Command ahead;
  ahead.axes[0] = 1.0;
  for (int k = 0; k < ticks(4.0); ++k)
    trip.step(ahead);
  EXPECT_GT((trip.posture().com - before).head<2>().norm(), 0.2 * robot_.profile().stance.com_height);
}

TEST_P(ArmsTest, TargetsThatAreNoneAreRefusedAndNothingChanges) {
  Trip trip(robot_);
  trip.step({});
  const std::string joint = joints().front();
  const std::string leg = robot_.joints()[static_cast<std::size_t>(robot_.leg(Side::left).front())].name;
  const MatX one = MatX::Zero(1, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const ArmTargets& targets :
       {ArmTargets{{leg}, {1.0}, one}, ArmTargets{{"no such joint"}, {1.0}, one}, ArmTargets{{joint}, {nan}, one},
        ArmTargets{{joint}, {1.0}, MatX::Constant(1, 1, nan)}, ArmTargets{{joint}, {1.0, 1.0}, MatX::Zero(2, 1)},
        ArmTargets{{joint, joint}, {1.0}, MatX::Zero(1, 2)}, ArmTargets{{joint}, {1.0}, MatX::Zero(2, 1)},
        ArmTargets{{}, {1.0}, MatX::Zero(1, 0)}})
    EXPECT_THROW(trip.navigator().drive_arms(targets), InputError);
  EXPECT_TRUE(trip.navigator().arms().empty());
}

}  // namespace
}  // namespace baton
