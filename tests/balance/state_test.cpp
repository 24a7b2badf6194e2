#include "baton/balance/state.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;

class EstimatorTest : public testing::TestWithParam<std::string> {
 protected:
  /// Anywhere, anyhow: every joint in its range, everything moving.
  Measurement measurement() {
    const auto n = static_cast<Eigen::Index>(robot_.joints().size());
    Measurement m;
    m.q.resize(n);
    m.dq.resize(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
      m.q[j] = random_(joint.position.lo, joint.position.hi);
      m.dq[j] = random_(-joint.speed, joint.speed);
    }
    m.root = RootMeasurement{random_.pose(), random_.vector(1.0), random_.vector(2.0)};
    return m;
  }

  /// The same robot `dt` later.
  [[nodiscard]] static Measurement later(const Measurement& m, double dt) {
    Measurement next = m;
    next.q += m.dq * dt;
    next.root->pose.p += m.root->velocity * dt;
    next.root->pose.R = m.root->pose.R * rotation_exp(m.root->rate * dt);
    return next;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  Random random_{11};
};

INSTANTIATE_TEST_SUITE_P(Robots, EstimatorTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(EstimatorTest, VelocitiesAreTheDerivativesOfTheState) {
  Estimator estimator(robot_);
  const double h = 1e-6;
  for (int trial = 0; trial < 2000; ++trial) {
    const Measurement m = measurement();
    const Pose anchor = random_.upright();
    const State before = estimator.update(later(m, -h), anchor);
    const State after = estimator.update(later(m, h), anchor);
    const State now = estimator.update(m, anchor);
    const double size = robot_.profile().stance.com_height;
    ASSERT_LT(((after.com - before.com) / (2 * h) - now.dcom).norm(), 1e-6 * size) << "trial " << trial;
    ASSERT_LT((rotation_error(after.trunk, before.trunk) / (2 * h) - now.trunk_rate).norm(), 1e-6);
    const double omega = robot_.omega();
    ASSERT_LT((now.dcm(omega) - now.com - now.dcom / omega).norm(), 1e-12);
  }
}

TEST_P(EstimatorTest, IsTheWorldSeenFromTheAnchor) {
  Estimator estimator(robot_);
  for (int trial = 0; trial < 2000; ++trial) {
    const Measurement m = measurement();
    const Pose anchor = random_.upright();
    const State in_world = estimator.update(m, Pose{});
    const State in_plan = estimator.update(m, anchor);
    ASSERT_LT((anchor * in_plan.com - in_world.com).norm(), 1e-9);
    ASSERT_LT((anchor.R * in_plan.dcom - in_world.dcom).norm(), 1e-9);
    ASSERT_LT((anchor.R * in_plan.trunk - in_world.trunk).norm(), 1e-9);
    ASSERT_LT((anchor.R * in_plan.trunk_rate - in_world.trunk_rate).norm(), 1e-9);
    for (const Side side : kSides) {
      ASSERT_LT((anchor * in_plan.sole[side].p - in_world.sole[side].p).norm(), 1e-9);
      ASSERT_LT((anchor.R * in_plan.sole[side].R - in_world.sole[side].R).norm(), 1e-9);
    }
  }
}

TEST_P(EstimatorTest, DoesNotSeeRobotAndAnchorMoveTogether) {
  Estimator estimator(robot_);
  for (int trial = 0; trial < 2000; ++trial) {
    const Measurement m = measurement();
    const Pose anchor = random_.upright();
    const Pose moved = random_.pose();
    Measurement elsewhere = m;
    elsewhere.root->pose = moved * m.root->pose;
    elsewhere.root->velocity = moved.R * m.root->velocity;
    const State a = estimator.update(m, anchor);
    const State b = estimator.update(elsewhere, moved * anchor);
    ASSERT_LT((a.com - b.com).norm(), 1e-9);
    ASSERT_LT((a.dcom - b.dcom).norm(), 1e-9);
    ASSERT_LT((a.trunk_rate - b.trunk_rate).norm(), 1e-9);
    ASSERT_LT((a.sole.left.p - b.sole.left.p).norm(), 1e-9);
    ASSERT_LT((a.q.tail(robot_.nv() - 6) - m.q).norm(), 1e-15);
  }
}

TEST_P(EstimatorTest, NeedsARoot) {
  Estimator estimator(robot_);
  Measurement m = measurement();
  m.root.reset();
  EXPECT_THROW(static_cast<void>(estimator.update(m, Pose{})), std::invalid_argument);
}

/// Soles as they may stand: some way apart, tilted a little.
BySide<Pose> standing_soles(Random& random) {
  BySide<Pose> soles;
  for (const Side side : kSides) {
    soles[side].p = Vec3(random(-0.2, 0.2), sign_of(side) * random(0.04, 0.2), random(-0.05, 0.05));
    soles[side].R = rotation_z(random(-0.4, 0.4)) * rotation_exp(Vec3(random(-0.05, 0.05), random(-0.05, 0.05), 0));
  }
  return soles;
}

double distance(const Pose& a, const Pose& b) {
  return (a.p - b.p).norm() + (a.R - b.R).norm();
}

TEST(AnchorCorrection, RecoversAPlanarMoveExactly) {
  Random random(5);
  for (int trial = 0; trial < 5000; ++trial) {
    const BySide<Pose> planned = standing_soles(random);
    const Pose moved = random.upright();
    const BySide<Pose> measured{moved * planned.left, moved * planned.right};
    for (const BySide<bool> contact : {BySide<bool>{true, true}, {true, false}, {false, true}}) {
      const Pose found = anchor_correction(planned, measured, contact);
      ASSERT_LT(distance(found, moved), 1e-12) << "trial " << trial;
      ASSERT_NEAR(found.R(2, 2), 1.0, 1e-15);
    }
  }
}

TEST(AnchorCorrection, DoesNotLookAtAFootInTheAir) {
  Random random(6);
  for (int trial = 0; trial < 2000; ++trial) {
    const BySide<Pose> planned = standing_soles(random);
    const Pose moved = random.upright();
    for (const Side stance : kSides) {
      BySide<Pose> measured{moved * planned.left, moved * planned.right};
      measured[other(stance)] = random.pose();
      const BySide<bool> contact{stance == Side::left, stance == Side::right};
      ASSERT_LT(distance(anchor_correction(planned, measured, contact), moved), 1e-12);
    }
  }
}

TEST(AnchorCorrection, LiesAsNearToBothSolesAsItCan) {
  Random random(7);
  for (int trial = 0; trial < 2000; ++trial) {
    const BySide<Pose> planned = standing_soles(random);
    const Pose moved = random.upright();
    BySide<Pose> measured{moved * planned.left, moved * planned.right};
    for (const Side side : kSides)
      measured[side].p += random.vector(0.01);
    const Pose found = anchor_correction(planned, measured, {true, true});
    const auto misfit = [&](const Pose& correction) {
      return (measured.left.p - correction * planned.left.p).squaredNorm() +
             (measured.right.p - correction * planned.right.p).squaredNorm();
    };
    const double least = misfit(found);
    for (int probe = 0; probe < 10; ++probe) {
      Pose near = found;
      near.p += random.vector(1e-3);
      ASSERT_GE(misfit(near), least);
    }
    // Soles that stand beside their place do not turn it, as zero errors of the encoders would.
    const double yaw = yaw_of(moved.R);
    ASSERT_NEAR(wrap_angle(yaw_of(found.R) - yaw), 0.0, 1e-12);
    const BySide<double> turn{random(-0.1, 0.1), random(-0.1, 0.1)};
    for (const Side side : kSides)
      measured[side].R = rotation_z(turn[side]) * measured[side].R;
    const double turned = yaw_of(anchor_correction(planned, measured, {true, true}).R);
    ASSERT_NEAR(wrap_angle(turned - yaw - 0.5 * (turn.left + turn.right)), 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace baton
