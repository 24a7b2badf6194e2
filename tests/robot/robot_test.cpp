// What every robot behind the port does, the ideal one and the simulated one.
#include "baton/robot/robot.hpp"

#include <gtest/gtest.h>

#include "baton/balance/stabiliser.hpp"
#include "baton/ik/stand.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

enum class Adapter { ideal, simulated };
using Kind = std::tuple<std::string, Adapter>;

class RobotTest : public testing::TestWithParam<Kind> {
 protected:
  [[nodiscard]] std::unique_ptr<Robot> make() const {
    if (ideal()) return std::make_unique<IdealRobot>(robot_, home_, period_);
    return std::make_unique<SimulatedRobot>(robot_, world_, home_, period_);
  }
  [[nodiscard]] static bool ideal() { return std::get<1>(GetParam()) == Adapter::ideal; }

  /// Tells the robot to stand still, but for an offset of its joints' angles.
  JointTarget hold(Robot& body, const VecX& offset) {
    const State& state = estimator_.update(body.read(), Pose{});
    JointTarget target = stabiliser_.target(held_, held_, state);
    target.q += offset;
    body.write(target);
    return target;
  }
  JointTarget hold(Robot& body) { return hold(body, VecX::Zero(n_)); }

  static bool finite(const Measurement& m) {
    bool all = std::isfinite(m.t) && m.q.allFinite() && m.dq.allFinite() && m.imu.attitude.allFinite() &&
               m.imu.rate.allFinite() && m.imu.acceleration.allFinite() && m.root.has_value() &&
               m.root->pose.p.allFinite() && m.root->pose.R.allFinite() && m.root->velocity.allFinite() &&
               m.root->rate.allFinite();
    for (const Side side : kSides)
      all = all && m.sole[side].force.allFinite() && m.sole[side].moment.allFinite();
    return all;
  }

  /// Of the forces on both soles, as the sensors say, on the floor.
  [[nodiscard]] Vec2 measured_zmp(const Measurement& m) {
    VecX q(robot_.nq());
    const Eigen::Quaterniond attitude(m.root->pose.R);
    q << m.root->pose.p, attitude.w(), attitude.x(), attitude.y(), attitude.z(), m.q;
    kinematics_.set(q);
    Wrench total;
    for (const Side side : kSides) {
      const Pose sole = kinematics_.sole(side);
      const Vec3 force = sole.R * m.sole[side].force;
      total.force += force;
      total.moment += sole.R * m.sole[side].moment + sole.p.cross(force);
    }
    return total.zmp(0.0);
  }

  const RobotModel& robot_ = test::robot(std::get<0>(GetParam()));
  const World world_ = World::load("flat");
  const double size_ = robot_.profile().stance.com_height;
  const double period_ = robot_.profile().tick.period;
  const int n_ = robot_.nv() - 6;
  const double weight_ = robot_.mass() * kGravity;
  const Posture home_ = stand(robot_, Pose{}, size_);
  const MotionSample held_ = resting(robot_, home_);
  Estimator estimator_{robot_};
  Stabiliser stabiliser_{robot_};
  Kinematics kinematics_{robot_};
};

std::string name_of_kind(const testing::TestParamInfo<Kind>& kind) {
  const auto& [robot, adapter] = kind.param;
  return robot + (adapter == Adapter::ideal ? "_ideal" : "_simulated");
}

INSTANTIATE_TEST_SUITE_P(Robots, RobotTest,
                         testing::Combine(testing::ValuesIn(test::robot_names()),
                                          testing::Values(Adapter::ideal, Adapter::simulated)),
                         name_of_kind);

TEST_P(RobotTest, BeginsInThePostureThatItWasGiven) {
  const auto body = make();
  const Measurement m = body->read();
  EXPECT_TRUE(finite(m));
  EXPECT_EQ(m.t, 0.0);
  EXPECT_EQ(m.q, home_.q.tail(n_));
  EXPECT_TRUE(m.dq.isZero(0.0));
  EXPECT_LT((m.root->pose.p - home_.q.head<3>()).norm(), 1e-12);
  EXPECT_TRUE(m.root->velocity.isZero(0.0));
  EXPECT_FALSE(body->truth()->fallen);
}

TEST_P(RobotTest, StandsStillWhereItIsTold) {
  const auto body = make();
  JointTarget target;
  for (int tick = 0; tick < 400; ++tick) {
    target = hold(*body);
    const Measurement m = body->read();
    ASSERT_TRUE(finite(m)) << "tick " << tick;
    ASSERT_NEAR(m.t, (tick + 1) * period_, 1e-9);
    ASSERT_EQ(m.q.size(), n_);
    ASSERT_EQ(m.dq.size(), n_);
    ASSERT_LT((m.q - target.q).cwiseAbs().maxCoeff(), ideal() ? 1e-15 : 0.02) << "tick " << tick;
    ASSERT_LT((m.q - home_.q.tail(n_)).cwiseAbs().maxCoeff(), ideal() ? 1e-15 : 0.02);
  }
  const Truth& truth = *body->truth();
  EXPECT_FALSE(truth.fallen) << truth.fall;
  EXPECT_TRUE(truth.touch.left);
  EXPECT_TRUE(truth.touch.right);
  const Measurement m = body->read();
  EXPECT_LT(m.dq.cwiseAbs().maxCoeff(), 0.01);
  // The ground carries the weight, half on each sole, and the sensors feel it.
  double normal = 0.0;
  for (const Side side : kSides) {
    const Wrench& sole = m.sole[side];
    normal += sole.force.z();
    EXPECT_NEAR(sole.force.z(), 0.5 * weight_, 0.05 * weight_);
    const Vec2 pressure(-sole.moment.y() / sole.force.z(), sole.moment.x() / sole.force.z());
    EXPECT_GT(robot_.sole(side).margin(pressure), 0.0);
  }
  EXPECT_NEAR(normal, weight_, 0.01 * weight_);
  kinematics_.set(truth.q);
  EXPECT_LT((measured_zmp(m) - kinematics_.com().head<2>()).norm(), 0.01 * size_);
  EXPECT_LT((m.imu.attitude * m.imu.acceleration - Vec3(0, 0, kGravity)).norm(), 0.05 * kGravity);
  EXPECT_LT(m.imu.rate.norm(), 0.02);
}

TEST_P(RobotTest, MovesTheJointThatIsMeant) {
  // The arms, one joint after the other: whatever the order of the model's motors and joints.
  for (const Side side : kSides) {
    for (const int j : robot_.arm(side)) {
      const auto body = make();
      const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
      const double home = home_.q[7 + j];
      const double by = home - range.lo > range.hi - home ? -0.15 : 0.15;
      VecX offset = VecX::Zero(n_);
      for (int tick = 0; tick < 120; ++tick) {
        offset[j] = by * std::min(1.0, tick / 60.0);
        hold(*body, offset);
      }
      const VecX moved = body->read().q - home_.q.tail(n_);
      for (int i = 0; i < n_; ++i) {
        EXPECT_NEAR(moved[i], i == j ? by : 0.0, ideal() ? 1e-12 : 0.03) << "joint " << i << " when " << j << " moves";
      }
    }
  }
}

TEST_P(RobotTest, MeasuresWhatIsTrue) {
  const auto body = make();
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  VecX offset = VecX::Zero(n_);
  for (int tick = 0; tick < 200; ++tick) {
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side))
        offset[j] = std::clamp(offset[j] + 0.005 * uniform(random), -0.2, 0.2);
    }
    hold(*body, offset);
    const Measurement m = body->read();
    const Truth& truth = *body->truth();
    ASSERT_EQ(m.t, truth.t);
    ASSERT_EQ(m.q, truth.q.tail(n_));
    ASSERT_EQ(m.dq, truth.dq.tail(n_));
    kinematics_.set(truth.q);
    const Pose root = kinematics_.body(1);
    ASSERT_LT((m.root->pose.p - root.p).norm(), 1e-9);
    ASSERT_LT((m.root->pose.R - root.R).norm(), 1e-9);
    ASSERT_EQ(m.root->velocity, truth.dq.head<3>());
    ASSERT_EQ(m.root->rate, truth.dq.segment<3>(3));
    for (const Side side : kSides) {
      const Pose sole = kinematics_.sole(side);
      ASSERT_LT((sole.R * m.sole[side].force - truth.sole[side].force).norm(), 1e-9 * weight_);
      const Vec3 moment = sole.R * m.sole[side].moment + sole.p.cross(truth.sole[side].force);
      ASSERT_LT((moment - truth.sole[side].moment).norm(), 1e-9 * weight_);
    }
  }
}

TEST_P(RobotTest, IsNotDisturbedByBeingRead) {
  const auto once = make();
  const auto often = make();
  for (int tick = 0; tick < 100; ++tick) {
    const JointTarget target = hold(*once);
    for (int k = 0; k < 3; ++k)
      static_cast<void>(often->read());
    often->write(target);
    ASSERT_EQ(once->truth()->q, often->truth()->q);
    ASSERT_EQ(once->truth()->dq, often->truth()->dq);
    ASSERT_EQ(once->truth()->sole.left.force, often->truth()->sole.left.force);
  }
}

}  // namespace
}  // namespace baton
