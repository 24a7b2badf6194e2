#include "baton/ik/inverse_kinematics.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "baton/ik/stand.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Whether two solutions are the same, bit by bit.
bool identical(const VecX& a, const VecX& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

bool identical(const IkResult& a, const IkResult& b) {
  return a.residual.sole_position == b.residual.sole_position && a.residual.sole_rotation == b.residual.sole_rotation &&
         a.residual.com == b.residual.com && a.residual.trunk == b.residual.trunk &&
         a.residual.hand == b.residual.hand && a.iterations == b.iterations && a.bound_joint == b.bound_joint &&
         a.finite_targets == b.finite_targets;
}

class IkTest : public testing::TestWithParam<std::string> {
 protected:
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  bool chance(double share) { return uniform(0, 1) < share; }

  [[nodiscard]] int n() const { return robot_.nv() - 6; }
  [[nodiscard]] const Joint& joint(int j) const { return robot_.joints()[static_cast<std::size_t>(j)]; }

  /// Somewhere near standing, well inside the joints' ranges.
  VecX configuration(double legs) {
    VecX q = home_.q;
    VecX step = VecX::Zero(robot_.nv());
    step.head<3>() = vector(0.1 * size_);
    step.segment<3>(3) = vector(0.2);
    for (const Side side : kSides) {
      for (const int j : robot_.leg(side))
        step[6 + j] = uniform(-legs, legs);
    }
    integrate(robot_, q, step, 1.0);
    for (int j = 0; j < n(); ++j) {
      const Range& range = joint(j).position;
      const double room = 0.05 * (range.hi - range.lo);
      q[7 + j] = std::clamp(q[7 + j], range.lo + room, range.hi - room);
    }
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side)) {
        const Range& range = joint(j).position;
        q[7 + j] = range.lo + uniform(0.1, 0.9) * (range.hi - range.lo);
      }
    }
    return q;
  }

  /// Where the parts of a configuration are.
  IkTargets targets_of(const VecX& q, bool hands) {
    kinematics_.set(q);
    IkTargets targets;
    targets.com = kinematics_.com();
    targets.trunk = kinematics_.trunk().R;
    targets.arms = q.tail(n());
    for (const Side side : kSides) {
      targets.sole[side] = kinematics_.sole(side);
      if (hands) targets.hand[side] = kinematics_.hand(side);
    }
    return targets;
  }

  /// Both soles flat on the floor, the COM above their middle, arms at home.
  [[nodiscard]] IkTargets standing(double height) const {
    IkTargets targets;
    targets.com = Vec3(0, 0, height);
    targets.sole = home_.sole;
    targets.arms = home_.q.tail(n());
    return targets;
  }

  /// Anything, sensible or not.
  IkTargets wild_targets() {
    IkTargets targets = targets_of(configuration(0.6), chance(0.5));
    const auto spoil = [&](Vec3& p) {
      if (chance(0.3)) p += vector(size_);
      if (chance(0.05)) p[static_cast<Eigen::Index>(random_() % 3)] = chance(0.5) ? kNaN : kInfinity;
      if (chance(0.03)) p *= 1e200;
    };
    const auto turn = [&](Mat3& R) {
      if (chance(0.3)) R = rotation_exp(vector(3.0)) * R;
      if (chance(0.1)) R = rotation_exp(M_PI * vector(1.0).normalized()) * R;
      if (chance(0.05)) R(static_cast<Eigen::Index>(random_() % 3), 0) = kNaN;
      if (chance(0.03)) R.setZero();
    };
    spoil(targets.com);
    turn(targets.trunk);
    for (const Side side : kSides) {
      spoil(targets.sole[side].p);
      turn(targets.sole[side].R);
      if (!targets.hand[side]) continue;
      spoil(targets.hand[side]->p);
      turn(targets.hand[side]->R);
    }
    if (chance(0.2)) targets.arms[static_cast<Eigen::Index>(random_() % static_cast<unsigned>(n()))] = kNaN;
    if (chance(0.2)) targets.arms += VecX::NullaryExpr(n(), [&] { return uniform(-10, 10); });
    return targets;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const double size_ = robot_.profile().stance.com_height;
  const double unit_ = size_ / 0.26;  ///< heights below are those of a robot whose nominal one is 0.26 m
  const Posture home_ = stand(robot_, Pose{}, size_);
  const double period_ = robot_.profile().tick.period;
  InverseKinematics ik_{robot_};
  Kinematics kinematics_{robot_};
  std::mt19937_64 random_{17};
};

INSTANTIATE_TEST_SUITE_P(Robots, IkTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(IkTest, ReachesWhatIsReachable) {
  int arrived = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const IkTargets targets = targets_of(configuration(0.3), trial % 2 == 0);
    VecX q = home_.q;
    const IkResult result = ik_.solve(targets, home_.q, kInfinity, q, 60);
    ASSERT_TRUE(result.finite_targets);
    // From afar an arm may not find its way, and then pulls a little.
    const bool hands_arrived = result.residual.hand <= 1e-5;
    ASSERT_TRUE(hands_arrived || trial % 2 == 0);
    arrived += hands_arrived;
    const double tolerance = hands_arrived ? 1e-6 : robot_.profile().ik.position;
    ASSERT_LE(result.residual.sole_position, tolerance) << "trial " << trial << ", joint " << result.bound_joint;
    ASSERT_LE(result.residual.sole_rotation, tolerance);
    ASSERT_LE(result.residual.com, tolerance);
    ASSERT_TRUE(!hands_arrived || result.residual.trunk <= 1e-4) << result.residual.trunk;
    // What is said to be left is what is left.
    kinematics_.set(q);
    ASSERT_LE((kinematics_.com() - targets.com).norm(), tolerance);
    for (const Side side : kSides) {
      ASSERT_LE((kinematics_.sole(side).p - targets.sole[side].p).norm(), tolerance);
      ASSERT_LE(rotation_error(targets.sole[side].R, kinematics_.sole(side).R).norm(), tolerance);
      if (targets.hand[side]) {
        ASSERT_LE((kinematics_.hand(side).p - targets.hand[side]->p).norm(), result.residual.hand + 1e-12);
      } else {
        for (const int j : robot_.arm(side))
          ASSERT_NEAR(q[7 + j], targets.arms[j], 1e-5);
      }
    }
  }
  EXPECT_GT(arrived, 1400);
}

TEST_P(IkTest, BringsBothHandsWhereTheyCanBe) {
  // From near: an arm has postures that lead nowhere when the hand is on the other side of it.
  for (int trial = 0; trial < 1000; ++trial) {
    const VecX goal = configuration(0.3);
    VecX q = goal;
    VecX step = VecX::NullaryExpr(robot_.nv(), [&] { return uniform(-0.05, 0.05); });
    integrate(robot_, q, step, 1.0);
    const IkTargets targets = targets_of(goal, true);
    const IkResult result = ik_.solve(targets, q, kInfinity, q, 60);
    ASSERT_LE(result.residual.hand, 1e-4) << "trial " << trial << ", joint " << result.bound_joint;
    ASSERT_LE(result.residual.com, 1e-6);
    ASSERT_LE(result.residual.sole_position, 1e-6);
    ASSERT_LE(result.residual.trunk, 1e-4);
  }
}

TEST_P(IkTest, IsAPureFunction) {
  for (int trial = 0; trial < 1000; ++trial) {
    const IkTargets targets = wild_targets();
    const VecX previous = configuration(0.3);
    const double dt = chance(0.5) ? period_ : kInfinity;
    const int iterations = 1 + static_cast<int>(random_() % 5);
    InverseKinematics fresh(robot_);
    VecX first = previous;
    VecX second = previous;
    const IkResult with_history = ik_.solve(targets, previous, dt, first, iterations);
    const IkResult without = fresh.solve(targets, previous, dt, second, iterations);
    ASSERT_TRUE(identical(first, second)) << "trial " << trial;
    ASSERT_TRUE(identical(with_history, without)) << "trial " << trial;
    ASSERT_TRUE(identical(first, [&] {
      VecX third = previous;
      fresh.solve(targets, previous, dt, third, iterations);
      return third;
    }()));
  }
}

TEST_P(IkTest, NeverBreaksABoundWhateverIsAsked) {
  int bounded = 0;
  int ignored = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const IkTargets targets = wild_targets();
    VecX previous = configuration(1.0);
    if (chance(0.2)) {  // some joints just at their limits
      for (int j = 0; j < n(); j += 3)
        previous[7 + j] = chance(0.5) ? joint(j).position.lo : joint(j).position.hi;
    }
    VecX q = previous;
    if (chance(0.3)) q.tail(n()) += VecX::NullaryExpr(n(), [&] { return uniform(-3, 3); });
    const double dt = chance(0.7) ? period_ : kInfinity;
    const IkResult result = ik_.solve(targets, previous, dt, q, 1 + static_cast<int>(random_() % 8));
    ASSERT_TRUE(q.allFinite()) << "trial " << trial;
    ASSERT_NEAR(q.segment<4>(3).norm(), 1.0, 1e-9);
    for (int j = 0; j < n(); ++j) {
      ASSERT_GE(q[7 + j], joint(j).position.lo) << "trial " << trial << ": " << joint(j).name;
      ASSERT_LE(q[7 + j], joint(j).position.hi) << "trial " << trial << ": " << joint(j).name;
      ASSERT_LE(std::abs(q[7 + j] - previous[7 + j]), joint(j).speed * dt + 1e-12)
          << "trial " << trial << ": " << joint(j).name;
    }
    const IkResidual& r = result.residual;
    ASSERT_TRUE(std::isfinite(r.com + r.hand + r.sole_position + r.sole_rotation + r.trunk));
    bounded += result.bound_joint >= 0;
    ignored += !result.finite_targets;
  }
  EXPECT_GT(bounded, 800);
  EXPECT_GT(ignored, 300);
}

TEST_P(IkTest, IgnoresATargetThatIsNotANumberAndServesTheOthers) {
  // Two solutions of the same problem: the part without a target stays, all the others come where they
  // should.
  for (int trial = 0; trial < 500; ++trial) {
    const Side side = kSides[static_cast<std::size_t>(trial) % 2];
    IkTargets targets = standing(uniform(0.24, 0.28) * unit_);
    targets.hand[side] = Pose{Vec3(kNaN, 0, 0), Mat3::Identity()};
    if (trial % 3 == 0) targets.trunk(1, 2) = kNaN;
    VecX q = home_.q;
    const IkResult result = ik_.solve(targets, home_.q, kInfinity, q, 40);
    ASSERT_FALSE(result.finite_targets);
    ASSERT_LE(result.residual.com, 1e-6);
    ASSERT_LE(result.residual.sole_position, 1e-6);
    ASSERT_TRUE(q.allFinite());
  }
}

TEST_P(IkTest, FollowsFromDeepKneesToNearlyStraightOnesAndBack) {
  constexpr int kTicks = 300;
  VecX q = home_.q;
  ik_.solve(standing(0.235 * unit_), home_.q, kInfinity, q, 50);
  const VecX deep = q;
  VecX before = q;
  double largest = 0.0;
  for (int k = 1; k <= 2 * kTicks; ++k) {
    const double s = 0.5 - 0.5 * std::cos(M_PI * k / kTicks);
    const IkTargets targets = standing((0.235 + s * (0.29 - 0.235)) * unit_);
    const VecX previous = q;
    q.tail(n()) += (previous - before).tail(n());
    q.head<3>() += (previous - before).head<3>();
    const IkResult result = ik_.solve(targets, previous, period_, q, 3);
    ASSERT_LE(result.residual.com, 1e-6) << "tick " << k;
    ASSERT_LE(result.residual.sole_position, 1e-6) << "tick " << k;
    ASSERT_LE(result.residual.sole_rotation, 1e-6) << "tick " << k;
    ASSERT_LE(result.residual.trunk, 1e-4) << "tick " << k;
    ASSERT_EQ(result.bound_joint, -1) << joint(result.bound_joint).name;
    largest = std::max(largest, (q - previous).tail(n()).cwiseAbs().maxCoeff());
    before = previous;
  }
  // Nearly straight knees turn fastest, yet no joint ever jumps: 100 degrees in 300 ticks, and some.
  EXPECT_LT(largest, 0.03);
  EXPECT_LT((q - deep).tail(n()).cwiseAbs().maxCoeff(), 1e-5);
}

TEST_P(IkTest, WhatIsTooHighDoesNotMakeItSwing) {
  // The COM rises beyond what the legs can reach and comes down again. Nothing jumps meanwhile.
  constexpr int kTicks = 400;
  VecX q = home_.q;
  for (int k = 1; k <= 2 * kTicks; ++k) {
    const double s = 0.5 - 0.5 * std::cos(M_PI * k / kTicks);
    const VecX previous = q;
    ik_.solve(standing(size_ + s * 0.06 * unit_), previous, period_, q, 3);
    ASSERT_TRUE(q.allFinite());
    for (int j = 0; j < n(); ++j)
      ASSERT_LE(std::abs(q[7 + j] - previous[7 + j]), joint(j).speed * period_ + 1e-12);
  }
  for (int k = 0; k < 100; ++k) {
    const VecX previous = q;
    ik_.solve(standing(size_), previous, period_, q, 3);
  }
  EXPECT_LT((q - home_.q).cwiseAbs().maxCoeff(), 1e-4);
}

TEST_P(IkTest, AnUnreachableHandDoesNotDisturbFeetAndCom) {
  const Profile::Ik& tolerance = robot_.profile().ik;
  int unreached = 0;  // the trunk bends to help
  for (int trial = 0; trial < 400; ++trial) {
    IkTargets targets = standing(uniform(0.24, 0.275) * unit_);
    targets.com.head<2>() += 0.05 * vector(size_).head<2>();
    const Side side = kSides[static_cast<std::size_t>(trial) % 2];
    // From just out of reach to far away.
    const Vec3 away = vector(1.0).normalized();
    targets.hand[side] = Pose{home_.hand[side].p + uniform(0.7, 4.0) * size_ * away, Mat3::Identity()};
    VecX q = home_.q;
    const IkResult result = ik_.solve(targets, home_.q, kInfinity, q, 60);
    ASSERT_LE(result.residual.sole_position, tolerance.position) << "trial " << trial;
    ASSERT_LE(result.residual.sole_rotation, tolerance.rotation) << "trial " << trial;
    ASSERT_LE(result.residual.com, tolerance.position) << "trial " << trial;
    unreached += result.residual.hand > 0.05 * size_;
  }
  EXPECT_GT(unreached, 250);
}

TEST_P(IkTest, AHandGoesOutOfReachAndComesBack) {
  constexpr int kTicks = 300;
  const Profile::Ik& tolerance = robot_.profile().ik;
  for (int trial = 0; trial < 15; ++trial) {
    const Side side = kSides[static_cast<std::size_t>(trial) % 2];
    const Vec3 away = (Vec3(1.0, 0, 0) + vector(0.7)).normalized();
    VecX q = home_.q;
    IkTargets targets = standing(size_);
    IkResult result;
    bool bound = false;
    for (int k = 1; k <= 2 * kTicks; ++k) {
      const double s = 0.5 - 0.5 * std::cos(M_PI * k / kTicks);
      targets.hand[side] = home_.hand[side];
      targets.hand[side]->p += s * 1.2 * size_ * away;
      const VecX previous = q;
      result = ik_.solve(targets, previous, period_, q, 3);
      bound = bound || result.bound_joint >= 0;
      ASSERT_LE(result.residual.sole_position, tolerance.position) << "trial " << trial << ", tick " << k;
      ASSERT_LE(result.residual.com, tolerance.position) << "trial " << trial << ", tick " << k;
      for (int j = 0; j < n(); ++j) {
        ASSERT_LE(std::abs(q[7 + j] - previous[7 + j]), joint(j).speed * period_ + 1e-12);
      }
    }
    for (int k = 0; k < 100; ++k) {
      const VecX previous = q;
      result = ik_.solve(targets, previous, period_, q, 3);
    }
    EXPECT_LE(result.residual.hand, 1e-4) << "trial " << trial;
    EXPECT_LE(result.residual.com, 1e-6);
    EXPECT_LE(result.residual.sole_position, 1e-6);
  }
}

TEST_P(IkTest, NoJointStaysAtABoundThatIsNoLongerNeeded) {
  // Without hands to guide, targets leave no freedom: after a way far out of reach the configuration is the
  // one that is found directly.
  int bound = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const IkTargets back = standing(uniform(0.24, 0.275) * unit_);
    VecX direct = home_.q;
    ASSERT_LE(ik_.solve(back, home_.q, kInfinity, direct, 60).residual.com, 1e-6);
    IkTargets far = back;
    far.com += 0.5 * vector(size_);
    far.sole[kSides[static_cast<std::size_t>(trial) % 2]].p += 0.3 * vector(size_);
    far.trunk = rotation_exp(vector(0.5));
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side))
        far.arms[j] = joint(j).position.hi + 1.0;
    }
    VecX q = direct;
    for (int k = 0; k < 30; ++k) {
      const VecX previous = q;
      bound += ik_.solve(far, previous, period_, q, 3).bound_joint >= 0;
    }
    ASSERT_GT((q - direct).tail(n()).cwiseAbs().maxCoeff(), 0.05);
    IkResult result;
    for (int k = 0; k < 300; ++k) {
      const VecX previous = q;
      result = ik_.solve(back, previous, period_, q, 3);
    }
    EXPECT_LE(result.residual.com, 1e-6) << "trial " << trial << ", joint " << result.bound_joint;
    EXPECT_LE(result.residual.sole_position, 1e-6) << "trial " << trial;
    EXPECT_EQ(result.bound_joint, -1) << "trial " << trial;
    EXPECT_LT((q - direct).tail(n()).cwiseAbs().maxCoeff(), 1e-4) << "trial " << trial;
  }
  EXPECT_GT(bound, 400);
}

TEST_P(IkTest, AShortArmFollowsThePositionOfItsHandOnly) {
  for (int trial = 0; trial < 500; ++trial) {
    const Side side = kSides[static_cast<std::size_t>(trial) % 2];
    ASSERT_LT(robot_.arm(side).size(), 6u);
    IkTargets targets = targets_of(configuration(0.2), true);
    IkTargets turned = targets;
    turned.hand[side]->R = rotation_exp(vector(3.0)) * targets.hand[side]->R;
    VecX q = home_.q;
    VecX other = home_.q;
    const IkResult a = ik_.solve(targets, home_.q, period_, q, 4);
    const IkResult b = ik_.solve(turned, home_.q, period_, other, 4);
    ASSERT_TRUE(identical(q, other));
    ASSERT_TRUE(identical(a, b));
  }
}

TEST_P(IkTest, BoundedAndFreeStepAgreeWhereTheBoundsBegin) {
  // One step: a hair's breadth inside the speed bounds the free solution stands, a hair's breadth outside the
  // bounded one. They are the same.
  int compared = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const VecX start = configuration(0.2);
    VecX goal = start;
    integrate(robot_, goal, VecX::NullaryExpr(robot_.nv(), [&] { return uniform(-0.02, 0.02); }), 1.0);
    for (int j = 0; j < n(); ++j)
      goal[7 + j] = std::clamp(goal[7 + j], joint(j).position.lo, joint(j).position.hi);
    const IkTargets targets = targets_of(goal, trial % 2 == 0);
    VecX free = start;
    ASSERT_EQ(ik_.solve(targets, start, 100.0, free, 1).bound_joint, -1);
    double needed = 0.0;  // time in which the fastest joint can make its step
    for (int j = 0; j < n(); ++j)
      needed = std::max(needed, std::abs(free[7 + j] - start[7 + j]) / joint(j).speed);
    VecX inside = start;
    VecX outside = start;
    ASSERT_EQ(ik_.solve(targets, start, needed * (1.0 + 1e-7), inside, 1).bound_joint, -1);
    if (ik_.solve(targets, start, needed * (1.0 - 1e-7), outside, 1).bound_joint < 0) continue;
    ++compared;
    ASSERT_LT((inside - free).cwiseAbs().maxCoeff(), 1e-12);
    ASSERT_LT((outside - free).cwiseAbs().maxCoeff(), 1e-6) << "trial " << trial;
  }
  EXPECT_GT(compared, 400);
}

TEST_P(IkTest, StandsAtEveryHeightItIsAllowed) {
  const Range& heights = robot_.profile().region.com_height;
  for (int k = 0; k <= 40; ++k) {
    const Pose start{vector(2.0), rotation_z(uniform(-3, 3))};
    const double height = heights.lo + (heights.hi - heights.lo) * k / 40.0;
    const Posture posture = stand(robot_, start, height);
    kinematics_.set(posture.q);
    EXPECT_LT((kinematics_.com() - start * Vec3(0, 0, height)).norm(), 1e-6);
    EXPECT_LT(rotation_error(start.R, kinematics_.trunk().R).norm(), 1e-4);
    for (const Side side : kSides) {
      const Vec3 place(0, sign_of(side) * 0.5 * robot_.profile().stance.width, 0);
      EXPECT_LT((kinematics_.sole(side).p - start * place).norm(), 1e-6);
      EXPECT_LT(rotation_error(start.R, kinematics_.sole(side).R).norm(), 1e-6);
      for (const int j : robot_.arm(side))
        EXPECT_NEAR(posture.q[7 + j], joint(j).home, 1e-5);
    }
  }
}

}  // namespace
}  // namespace baton
