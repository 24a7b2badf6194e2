#include "baton/balance/stabiliser.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

/// Two ticks of a motion, as the navigator passes them on.
struct TwoTicks {
  MotionSample now;
  MotionSample next;
};

class StabiliserTest : public testing::TestWithParam<std::string> {
 protected:
  const std::vector<TwoTicks>& moments() {
    static std::map<std::string, std::vector<TwoTicks>> known;
    std::vector<TwoTicks>& list = known[GetParam()];
    if (!list.empty()) return list;
    for (const VerifiedMotion& verified : test::sample_motions(GetParam())) {
      const Motion& motion = *verified;
      for (std::size_t k = 0; k + 1 < motion.samples.size(); k += 7) {
        list.push_back({motion.samples[k], motion.samples[k + 1]});
      }
    }
    return list;
  }

  /// The state of a robot that is just where the plan says.
  [[nodiscard]] State as_planned(const MotionSample& sample) {
    State state;
    state.q = sample.q;
    state.com = sample.com;
    state.dcom = sample.dcom;
    state.sole = sample.sole;
    kinematics_.set(sample.q);
    state.trunk = kinematics_.trunk().R;
    JacobianRows jacobian(3, robot_.nv());
    kinematics_.rotation_jacobian(robot_.trunk_body(), jacobian);
    state.trunk_rate = jacobian * sample.dq;
    return state;
  }

  /// The wrench from the ground that these torques mean, read back through the legs: of a standing leg the
  /// six rows of τ = ID − Jᵀf give f.
  [[nodiscard]] Wrench wrench_of(const MotionSample& sample, const VecX& tau) {
    kinematics_.set(sample.q);
    Wrench total;
    for (const Side side : kSides) {
      if (!sample.contact[side]) continue;
      JacobianRows jacobian(6, robot_.nv());
      const Vec3 centre = kinematics_.sole(side).p;
      kinematics_.point_jacobian(robot_.foot_body(side), centre, jacobian.topRows(3));
      kinematics_.rotation_jacobian(robot_.foot_body(side), jacobian.bottomRows(3));
      Eigen::Matrix<double, 6, 6> transposed;
      Vec6 rest;
      for (int i = 0; i < 6; ++i) {
        const int j = robot_.leg(side)[static_cast<std::size_t>(i)];
        transposed.row(i) = jacobian.col(6 + j).transpose();
        const double damping = robot_.joints()[static_cast<std::size_t>(j)].motor.damping;
        rest[i] = sample.force[6 + j] - (tau[j] - damping * sample.dq[6 + j]);
      }
      const Vec6 f = transposed.fullPivLu().solve(rest);
      total.force += f.head<3>();
      total.moment += f.tail<3>() + centre.cross(f.head<3>());
    }
    return total;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  Kinematics kinematics_{robot_};
};

INSTANTIATE_TEST_SUITE_P(Robots, StabiliserTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(StabiliserTest, WithoutErrorIsInverseDynamicsWithTheContactForces) {
  Stabiliser stabiliser(robot_);
  ASSERT_GT(moments().size(), 200u);
  int single = 0;
  const double weight = robot_.mass() * kGravity;
  for (const TwoTicks& moment : moments()) {
    const MotionSample& next = moment.next;
    stabiliser.reset();
    const JointTarget& target = stabiliser.target(moment.now, next, as_planned(moment.now));
    EXPECT_EQ(target.q, next.q.tail(robot_.nv() - 6));
    EXPECT_EQ(target.dq, next.dq.tail(robot_.nv() - 6));
    EXPECT_EQ(target.ddq, next.ddq.tail(robot_.nv() - 6));
    EXPECT_EQ(target.contact.left, next.contact.left);
    EXPECT_EQ(target.contact.right, next.contact.right);
    EXPECT_LT(stabiliser.correction().dcm_error.norm(), 1e-12);

    // The wrench that the torques mean is what inverse dynamics asks of the ground.
    const ConvexPolygon allowed = support_polygon(robot_, next.sole, next.contact, next.com, next.zmp_height)
                                      .inset(robot_.profile().margin.zmp_feedback);
    if (allowed.margin(next.zmp) < 0.0) continue;  // then the ZMP is brought inside
    kinematics_.set(next.q);
    const Wrench wanted = ground_wrench(kinematics_, next.force);
    const Wrench read = wrench_of(next, target.tau);
    EXPECT_LT((read.force - wanted.force).norm(), 1e-6 * weight);
    EXPECT_LT((read.zmp(next.zmp_height) - next.zmp).norm(), 1e-6);
    EXPECT_LT((read.moment - wanted.moment).norm(), 1e-6 * weight);
    // No sole pulls at the arms.
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side)) {
        const double damping = robot_.joints()[static_cast<std::size_t>(j)].motor.damping;
        EXPECT_NEAR(target.tau[j], next.force[6 + j] + damping * next.dq[6 + j], 1e-9 * weight);
      }
    }
    if (next.contact.left != next.contact.right) {
      ++single;
      const Side swing = next.contact.left ? Side::right : Side::left;
      for (const int j : robot_.leg(swing)) {
        const double damping = robot_.joints()[static_cast<std::size_t>(j)].motor.damping;
        EXPECT_NEAR(target.tau[j], next.force[6 + j] + damping * next.dq[6 + j], 1e-9 * weight);
      }
    }
  }
  EXPECT_GT(single, 20);
}

TEST_P(StabiliserTest, AnErrorOfTheDcmMovesTheZmpOutwardAndKeepsItInside) {
  Stabiliser stabiliser(robot_);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double size = robot_.profile().stance.com_height;
  const double omega = robot_.omega();
  const double gain = 1.0 + robot_.profile().stabiliser.k_dcm / omega;
  int free = 0;
  int clamped = 0;
  int exact = 0;
  for (const TwoTicks& moment : moments()) {
    for (int trial = 0; trial < 5; ++trial) {
      const MotionSample& next = moment.next;
      // Position and velocity share the error as they like: only the DCM counts.
      const double scale = size * std::pow(10.0, 1.5 * (uniform(random) - 1.0));
      const Vec3 dp = scale * Vec3(uniform(random), uniform(random), 0);
      const Vec3 dv = scale * omega * Vec3(uniform(random), uniform(random), 0);
      stabiliser.reset();
      State state = as_planned(moment.now);
      state.com += dp;
      state.dcom += dv;
      const Vec2 error = (dp + dv / omega).head<2>();
      const JointTarget& target = stabiliser.target(moment.now, next, state);
      ASSERT_TRUE(target.tau.allFinite());
      const Correction& correction = stabiliser.correction();
      ASSERT_LT((correction.dcm_error.head<2>() - error).norm(), 1e-12);

      const double margin = robot_.profile().margin.zmp_feedback;
      const ConvexPolygon support = support_polygon(robot_, next.sole, next.contact, next.com, next.zmp_height);
      ASSERT_GE(support.margin(correction.zmp), margin - 1e-9);
      if (support.margin(next.zmp) >= margin) {
        ASSERT_GE((correction.zmp - next.zmp).dot(error), -1e-12);
      }
      const Vec2 wish = next.zmp + gain * error;
      if (support.margin(wish) >= margin + 1e-9) {
        ASSERT_LT((correction.zmp - wish).norm(), 1e-12);
        ++free;
      } else {
        // Of all points allowed, the nearest to the wish.
        const ConvexPolygon allowed = support.inset(margin);
        for (const Vec2& vertex : allowed.vertices()) {
          ASSERT_LE((correction.zmp - wish).norm(), (vertex - wish).norm() + 1e-12);
        }
        ++clamped;
      }
      // And the torques say the same, unless the soles would slide.
      const Wrench given = wrench_of(next, target.tau);
      const double off = (given.zmp(next.zmp_height) - correction.zmp).norm();
      const Vec2 push = (correction.zmp - next.zmp) / (next.com.z() - next.zmp_height);
      kinematics_.set(next.q);
      const Vec3 planned = ground_wrench(kinematics_, next.force).force;
      const Vec2 slope = planned.head<2>() / planned.z() - push;
      if (slope.norm() < 0.3) {
        ASSERT_LT(off, 0.03 * size);
      }
      exact += off < 1e-6 ? 1 : 0;
    }
  }
  EXPECT_GT(exact, (free + clamped) * 4 / 5);
  EXPECT_GT(free, 200);
  EXPECT_GT(clamped, 200);
}

// What the ground gives in addition accelerates the whole robot; whatever does not hang from a leg needs its part of
// that through its own joint. By Newton and Euler, link by link.
TEST_P(StabiliserTest, TheUpperBodyIsCarriedAlongWithACorrection) {
  Stabiliser stabiliser(robot_);
  const mjModel& m = robot_.mj();
  const double unit = robot_.mass() * kGravity * robot_.profile().stance.com_height;
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double largest = 0.0;
  for (const TwoTicks& moment : moments()) {
    const MotionSample& next = moment.next;
    State state = as_planned(moment.now);
    // The first tick is without feedback; what is learned from it is in both.
    stabiliser.reset();
    (void)stabiliser.target(moment.now, next, state);
    const VecX without = stabiliser.target(moment.now, next, state).tau;
    stabiliser.reset();
    (void)stabiliser.target(moment.now, next, state);
    state.com += 0.02 * robot_.profile().stance.com_height * Vec3(uniform(random), uniform(random), 0.0);
    state.trunk = rotation_exp(0.02 * Vec3(uniform(random), uniform(random), 0.0)) * state.trunk;
    const VecX with = stabiliser.target(moment.now, next, state).tau;
    const Wrench read = wrench_of(next, with);
    kinematics_.set(next.q);
    const Wrench planned = ground_wrench(kinematics_, next.force);
    const Vec3 com = kinematics_.com();
    const Vec3 force = read.force - planned.force;
    const Vec3 turning = read.moment - planned.moment - com.cross(force);
    const Vec3 push = force / robot_.mass();
    const Vec3 turn = kinematics_.inertia().inverse() * turning;
    // Only where the ground can give all of it: else the correction itself is changed.
    const Vec2 shift = stabiliser.correction().zmp - next.zmp;
    if ((read.zmp(next.zmp_height) - next.zmp - shift).norm() > 1e-6) continue;
    for (const Side side : kSides) {
      const int hand = robot_.hand_body(side);
      const int last = robot_.arm(side).back();  // it moves the hand, with all that is on it
      const Kinematics::Axis& axis = kinematics_.dof_axis(6 + last);
      double expected = 0.0;
      for (int b = 1; b < m.nbody; ++b) {
        const auto moved = [&](int body) {
          const auto& dofs = robot_.dofs_to(body);
          return std::ranges::count(dofs, 6 + last) > 0;
        };
        if (!moved(b)) continue;
        const Pose& link = kinematics_.body(b);
        const Vec3 at = link * Vec3(Eigen::Map<const Vec3>(m.body_ipos + 3 * b));
        const double* w = m.body_iquat + 4 * b;
        const Mat3 axes = link.R * Eigen::Quaterniond(w[0], w[1], w[2], w[3]).toRotationMatrix();
        const Vec3 inertial = m.body_mass[b] * (push + turn.cross(at - com));
        const Mat3 inertia =
            axes * Vec3(Eigen::Map<const Vec3>(m.body_inertia + 3 * b)).asDiagonal() * axes.transpose();
        expected += axis.direction.dot((at - axis.point).cross(inertial) + inertia * turn);
      }
      EXPECT_TRUE(std::ranges::count(robot_.dofs_to(hand), 6 + last) > 0);
      EXPECT_NEAR(with[last] - without[last], expected, 1e-6 * unit);
      largest = std::max(largest, std::abs(expected) / unit);
    }
  }
  EXPECT_GT(largest, 1e-5);
}

TEST_P(StabiliserTest, AnErrorOfTheDcmIsAForceAtTheComNotAMomentAboutIt) {
  Stabiliser stabiliser(robot_);
  const double weight = robot_.mass() * kGravity;
  const double height = robot_.profile().stance.com_height;
  int moved = 0;
  for (const TwoTicks& moment : moments()) {
    const MotionSample& next = moment.next;
    stabiliser.reset();
    State state = as_planned(moment.now);
    state.com += Vec3(0.01, -0.007, 0) * height;
    const VecX tau = stabiliser.target(moment.now, next, state).tau;
    kinematics_.set(next.q);
    const Wrench planned = ground_wrench(kinematics_, next.force);
    const Wrench read = wrench_of(next, tau);
    const Vec2 shift = stabiliser.correction().zmp - next.zmp;
    const Vec2 force = -planned.force.z() / (next.com.z() - next.zmp_height) * shift;
    EXPECT_LT((read.force - planned.force - Vec3(force.x(), force.y(), 0)).norm(), 1e-6 * weight);
    EXPECT_LT((read.moment_about(next.com) - planned.moment_about(next.com)).norm(), 1e-6 * weight * height);
    if (shift.norm() > 0.005 * height) ++moved;
  }
  EXPECT_GT(moved, 200);
}

TEST_P(StabiliserTest, ATrunkThatLeansIsTurnedBackWithTheRoomThatIsLeft) {
  Stabiliser stabiliser(robot_);
  const double unit = robot_.mass() * kGravity * robot_.profile().stance.com_height;
  int turned = 0;
  int without_room = 0;
  for (const TwoTicks& moment : moments()) {
    for (const double lean : {-0.03, 0.03}) {
      for (const double error : {0.0, 1.0}) {
        stabiliser.reset();
        static_cast<void>(stabiliser.target(moment.now, moment.now, as_planned(moment.now)));
        State state = as_planned(moment.now);
        state.trunk = rotation_exp({0, lean, 0}) * state.trunk;
        state.com.x() += error * robot_.profile().stance.com_height;
        const VecX tau = stabiliser.target(moment.now, moment.next, state).tau;
        kinematics_.set(moment.next.q);
        const Wrench planned = ground_wrench(kinematics_, moment.next.force);
        const Vec3& com = moment.next.com;
        const Vec3 about = wrench_of(moment.next, tau).moment_about(com) - planned.moment_about(com);
        const ConvexPolygon& region = *moment.next.zmp_region;
        EXPECT_GE(region.margin(stabiliser.correction().zmp), -1e-9);
        const double back = lean > 0.0 ? -about.y() : about.y();
        // Soles that would slide take from the moment, too.
        EXPECT_GT(back, error == 0.0 ? -2e-3 * unit : -0.06 * unit);
        turned += back > 0.01 * unit ? 1 : 0;
        if (error > 0.0 && lean > 0.0) without_room += std::abs(about.y()) < 1e-3 * unit ? 1 : 0;
      }
    }
  }
  EXPECT_GT(turned, 200);
  EXPECT_GT(without_room, 50) << "the DCM needs all of it";
}

TEST_P(StabiliserTest, AJointThatStaysBehindIsPushedByNoMoreThanVerifiedMotionsLeave) {
  Stabiliser stabiliser(robot_);
  const TwoTicks& moment = moments().front();
  const MotionSample rest = moment.now;
  State there = as_planned(rest);
  for (const Side side : kSides)
    there.force[side].force.z() = 0.5 * robot_.mass() * kGravity;
  State behind = there;
  behind.q.tail(robot_.nv() - 6).array() -= 0.2;
  const auto at_last = [&](const State& state) {
    stabiliser.reset();
    static_cast<void>(stabiliser.target(rest, rest, there));
    for (int k = 0; k < 4000; ++k)
      static_cast<void>(stabiliser.target(rest, rest, state));
    return VecX(stabiliser.target(rest, rest, state).tau);
  };
  const VecX before = at_last(there);
  const VecX after = at_last(behind);
  // All torques of the model are taken for too small or too large, too, by one factor. In the legs the contact forces
  // are shared otherwise as well, as far as the motors reach their limits.
  std::optional<double> factor;
  for (const Side side : kSides) {
    for (const int j : robot_.arm(side)) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
      const double room = (1.0 - robot_.profile().margin.torque) * joint.motor.stall;
      if (!factor) factor = (after[j] - room) / before[j];
      EXPECT_NEAR(after[j], *factor * before[j] + room, 1e-9 * joint.motor.stall) << joint.name;
    }
    for (const int j : robot_.leg(side)) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
      EXPECT_LE(std::abs(after[j]), joint.motor.stall) << joint.name;
    }
  }
  EXPECT_GE(*factor, 0.6);
  EXPECT_LE(*factor, 1.7);
  EXPECT_NE(*factor, 1.0);
  EXPECT_EQ(at_last(there), before) << "reset";
}

TEST_P(StabiliserTest, LearnsNothingOfTheLoadWhileSomethingElseCarriesTheRobot) {
  const MotionSample rest = moments().front().now;
  for (const double carried : {0.0, 0.3, 0.6, 1.0}) {
    Stabiliser stabiliser(robot_);
    State hangs = as_planned(rest);
    for (const Side side : kSides)
      hangs.force[side].force.z() = 0.5 * carried * robot_.mass() * kGravity;
    const VecX before = stabiliser.target(rest, rest, hangs).tau;
    for (const Side side : kSides) {  // the knee bends less than commanded: it carries less than the model says
      const int knee = robot_.leg(side)[3];
      hangs.q[7 + knee] += std::copysign(0.02, before[knee]);
    }
    for (int k = 0; k < 10; ++k)
      static_cast<void>(stabiliser.target(rest, rest, hangs));
    const VecX after = stabiliser.target(rest, rest, hangs).tau;
    const int elbow = robot_.arm(Side::left).back();  // whose servo has no error: only the factor changes its torque
    EXPECT_EQ(after[elbow] != before[elbow], carried == 1.0) << carried;
  }
}

TEST_P(StabiliserTest, KnowsWhatOfTheCommandedZmpTheGroundDoesNotGive) {
  const TwoTicks& moment = moments().front();
  const MotionSample& rest = moment.now;
  ASSERT_TRUE(rest.contact.left && rest.contact.right);
  const double weight = robot_.mass() * kGravity;
  const double h = robot_.profile().stance.com_height;
  // The weight, halved between the soles, with the ZMP so far from where it is commanded.
  for (const Vec2& off : {Vec2(0.0, 0.0), Vec2(0.1 * h, 0.0), Vec2(-0.05 * h, 0.08 * h)}) {
    Stabiliser stabiliser(robot_);
    State state = as_planned(rest);
    for (int k = 0; k < 400; ++k) {
      static_cast<void>(stabiliser.target(rest, rest, state));
      const Vec2 at = stabiliser.correction().zmp - off;
      for (const Side side : kSides) {
        const Vec2 lever = at - state.sole[side].p.head<2>();
        state.force[side] = {{0, 0, 0.5 * weight}, Vec3(lever.x(), lever.y(), 0).cross(Vec3(0, 0, 0.5 * weight))};
      }
    }
    EXPECT_LT((stabiliser.correction().zmp_deficit - off).norm(), 1e-3 * h);
    stabiliser.reset();
    EXPECT_EQ(stabiliser.correction().zmp_deficit, Vec2(0, 0));
  }
}

TEST_P(StabiliserTest, LearnsTheComOffsetFastAtFirstAndSlowlyLater) {
  const MotionSample& rest = moments().front().now;
  ASSERT_TRUE(rest.contact.left && rest.contact.right);
  const double h = robot_.profile().stance.com_height;
  const double weight = robot_.mass() * kGravity;
  const int moment = static_cast<int>(1.5 / robot_.omega() / robot_.profile().tick.period);
  for (const Vec2& off : {Vec2(0.1 * h, 0.0), Vec2(0.0, -0.1 * h), Vec2(-0.05 * h, 0.05 * h)}) {
    Stabiliser stabiliser(robot_);
    const auto live = [&](int ticks, const Vec2& beyond_plan) {
      State state = as_planned(rest);
      for (const Side side : kSides) {
        const Vec2 lever = rest.zmp + beyond_plan - state.sole[side].p.head<2>();
        state.force[side] = {{0, 0, 0.5 * weight}, Vec3(lever.x(), lever.y(), 0).cross(Vec3(0, 0, 0.5 * weight))};
      }
      for (int k = 0; k < ticks; ++k)
        static_cast<void>(stabiliser.target(rest, rest, state));
      return stabiliser.correction().com_offset;
    };
    live(1, Vec2::Zero());
    EXPECT_FALSE(stabiliser.correction().settling);
    live(1, off);
    EXPECT_TRUE(stabiliser.correction().settling);
    EXPECT_LT((live(moment, off) - off).norm(), 0.6 * off.norm());
    live(moment, off);
    live(5, -off);
    EXPECT_FALSE(stabiliser.correction().settling) << "no longer than that, whatever the offset does";
    stabiliser.reset();
    live(20 * moment, Vec2::Zero());
    EXPECT_LT(live(moment, off).norm(), 0.2 * off.norm());
    EXPECT_FALSE(stabiliser.correction().settling);
  }
}

TEST_P(StabiliserTest, MotorsAreSentPastTheirLinksToTheSideThatTheyPushTo) {
  const double play = 0.004;
  int whole = 0;
  int part = 0;
  for (const TwoTicks& moment : moments()) {
    Stabiliser without(robot_);
    Stabiliser with(robot_);
    const auto correction = [&](Stabiliser& stabiliser, double size) {
      VecX latest;
      for (int tick = 0; tick < 40; ++tick)  // long enough for the low-pass
        latest = stabiliser.target(moment.now, moment.now, as_planned(moment.now), 1.0, size).q_correction;
      return latest;
    };
    const VecX past = correction(with, play) - correction(without, 0.0);
    const VecX tau = with.target(moment.now, moment.now, as_planned(moment.now), 1.0, play).tau;
    for (Eigen::Index j = 0; j < past.size(); ++j) {
      const double most = std::min(play, std::abs(tau[j]) / robot_.joints()[static_cast<std::size_t>(j)].gains.kp);
      EXPECT_NEAR(past[j], std::copysign(most, tau[j]), 0.02 * play) << j;
      (most < play ? part : whole) += 1;
    }
  }
  EXPECT_GT(whole, 200);
  EXPECT_GT(part, 200);
}

}  // namespace
}  // namespace baton
