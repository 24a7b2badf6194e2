/// Arms that are driven from outside.
#include <gtest/gtest.h>

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
  [[nodiscard]] std::vector<std::string> joints() const {
    std::vector<std::string> names;
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side))
        names.push_back(robot_.joints()[static_cast<std::size_t>(j)].name);
    }
    return names;
  }
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
        ArmTargets{{joint, joint}, {1.0}, MatX::Zero(1, 2)}, ArmTargets{{joint}, {1.0}, MatX::Zero(2, 1)}})
    EXPECT_THROW(trip.navigator().drive_arms(targets), InputError);
  EXPECT_TRUE(trip.navigator().arms().empty());
}

}  // namespace
}  // namespace baton
