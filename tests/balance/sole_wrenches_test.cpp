#include "baton/balance/sole_wrenches.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/random.hpp"
#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

class SoleWrenchesTest : public testing::TestWithParam<std::string> {
 protected:
  /// What the soles give and the motor torques of a robot that moves as planned.
  struct Moment {
    MotionSample planned;
    BySide<Wrench> sole;  ///< in the sole frames
    VecX torque;
  };

  SoleWrenchesTest() {
    for (const VerifiedMotion& motion : test::sample_motions(GetParam())) {
      for (std::size_t k = 0; k < motion->samples.size(); k += 5)
        moments_.push_back(moment(motion->samples[k], shared(motion->samples[k])));
    }
  }

  BySide<Wrench> shared(const MotionSample& sample) {
    kinematics_.set(sample.q);
    return share_wrench(robot_, sample.sole, sample.contact, ground_wrench(kinematics_, sample.force));
  }

  /// @param contact wrench on each sole, about the origin
  Moment moment(const MotionSample& sample, const BySide<Wrench>& contact) {
    Moment moment{sample, {}, VecX(robot_.nv() - 6)};
    kinematics_.set(sample.q);
    joint_torques(kinematics_, sample.force, contact, moment.torque);
    for (Eigen::Index j = 0; j < moment.torque.size(); ++j)
      moment.torque[j] += robot_.joints()[static_cast<std::size_t>(j)].motor.damping * sample.dq[6 + j];
    for (const Side side : kSides) {
      const Pose sole = kinematics_.sole(side);
      const Mat3 axes = sole.R.transpose();
      moment.sole[side] = {axes * contact[side].force, axes * contact[side].moment_about(sole.p)};
    }
    return moment;
  }

  BySide<Wrench> estimate(const Moment& moment, const VecX& torque, const BySide<bool>& planned,
                          const Vec3& push = Vec3::Zero()) {
    return wrenches_.estimate(motion_of(moment.planned, push), torque, planned, kinematics_);
  }
  BySide<Wrench> by_legs(const Moment& moment, const VecX& torque) {
    return wrenches_.by_legs(motion_of(moment.planned), torque, kinematics_);
  }

  /// @param push what else accelerates the root [m/s²]
  [[nodiscard]] SoleWrenches::BodyMotion motion_of(const MotionSample& sample, const Vec3& push = Vec3::Zero()) const {
    return {sample.q, sample.dq, sample.ddq.head<3>() + push, sample.ddq.segment<3>(3),
            sample.ddq.tail(robot_.nv() - 6)};
  }

  /// Motor torques with friction of up to a twentieth of the stall torque.
  VecX with_friction(const VecX& torque, test::Random& random) {
    VecX measured = torque;
    for (Eigen::Index j = 0; j < measured.size(); ++j)
      measured[j] += random(-0.05, 0.05) * robot_.joints()[static_cast<std::size_t>(j)].motor.stall;
    return measured;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  Kinematics kinematics_{robot_};
  SoleWrenches wrenches_{robot_};
  const double weight_ = robot_.mass() * kGravity;
  const double height_ = robot_.profile().stance.com_height;
  std::vector<Moment> moments_;
};

INSTANTIATE_TEST_SUITE_P(Robots, SoleWrenchesTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(SoleWrenchesTest, ExactTorquesGiveThePlannedWrenches) {
  ASSERT_GT(moments_.size(), 200u);
  for (const Moment& moment : moments_) {
    const BySide<Wrench> found = estimate(moment, moment.torque, moment.planned.contact);
    for (const Side side : kSides) {
      EXPECT_LT((found[side].force - moment.sole[side].force).norm(), 1e-6 * weight_);
      EXPECT_LT((found[side].moment - moment.sole[side].moment).norm(), 1e-6 * weight_ * height_);
    }
  }
}

TEST_P(SoleWrenchesTest, TheLegsAloneTellThePlannedWrenchesToo) {
  for (const Moment& moment : moments_) {
    const BySide<Wrench> found = by_legs(moment, moment.torque);
    for (const Side side : kSides) {
      EXPECT_LT((found[side].force - moment.sole[side].force).norm(), 1e-6 * weight_);
      EXPECT_LT((found[side].moment - moment.sole[side].moment).norm(), 1e-6 * weight_ * height_);
    }
  }
}

TEST_P(SoleWrenchesTest, FrictionDisturbsLessThanByTheLegsAlone) {
  test::Random random(1);
  double together = 0.0, alone = 0.0;  // squared errors of the forces
  for (const Moment& moment : moments_) {
    const VecX torque = with_friction(moment.torque, random);
    const BySide<Wrench> found = estimate(moment, torque, moment.planned.contact);
    const BySide<Wrench> legs = by_legs(moment, torque);
    for (const Side side : kSides) {
      together += (found[side].force - moment.sole[side].force).squaredNorm();
      alone += (legs[side].force - moment.sole[side].force).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(together), 0.75 * std::sqrt(alone));
}

TEST_P(SoleWrenchesTest, AFootThatTouchesTheGroundTooEarlyIsFelt) {
  int steps = 0;
  for (const Moment& as_planned : moments_) {
    const MotionSample& sample = as_planned.planned;
    if (sample.contact.left && sample.contact.right) continue;
    ++steps;
    const Side down = sample.contact.left ? Side::left : Side::right;
    BySide<Wrench> contact = shared(sample);
    Wrench early;  // of the other foot, with a fifth of the weight, at its centre
    early.force = Vec3(0, 0, 0.2 * weight_);
    early.moment = sample.sole[other(down)].p.cross(early.force);
    contact[down] = {contact[down].force - early.force, contact[down].moment - early.moment};
    contact[other(down)] = early;
    const Moment touching = moment(sample, contact);
    const double load = estimate(touching, touching.torque, sample.contact)[other(down)].force.z();
    EXPECT_GT(load, 0.1 * weight_);
    EXPECT_LT(load, 0.25 * weight_);
  }
  EXPECT_GT(steps, 30);
}

TEST_P(SoleWrenchesTest, APushIsNotTakenForTheGroundWhole) {
  for (std::size_t k = 0; k < moments_.size(); k += 10) {
    const Moment& moment = moments_[k];
    // The trunk is pushed by a third of the weight: the acceleration shows it, the legs do not.
    const Vec3 push(0.3 * kGravity, 0, 0);
    const BySide<Wrench> found = estimate(moment, moment.torque, moment.planned.contact, push);
    Vec3 total = Vec3::Zero();
    for (const Side side : kSides)
      total += moment.planned.sole[side].R * (found[side].force - moment.sole[side].force);
    EXPECT_LT(total.norm(), 0.25 * weight_);
  }
}

TEST_P(SoleWrenchesTest, ARobotThatIsHeldUpIsNotCarriedByItsSoles) {
  test::Random random(2);
  for (std::size_t k = 0; k < moments_.size(); k += 10) {
    const Moment hanging = moment(moments_[k].planned, {});
    const BySide<Wrench> found = estimate(hanging, hanging.torque, hanging.planned.contact);
    EXPECT_LT(std::abs(found.left.force.z()) + std::abs(found.right.force.z()), 1e-6 * weight_);
    const BySide<Wrench> rough = estimate(hanging, with_friction(hanging.torque, random), hanging.planned.contact);
    EXPECT_LT(rough.left.force.z() + rough.right.force.z(), 0.5 * weight_);
  }
}

TEST_P(SoleWrenchesTest, APayloadThatTheModelDoesNotKnowShiftsTheZmp) {
  for (const Moment& as_planned : moments_) {
    const MotionSample& sample = as_planned.planned;
    if (!sample.contact.left || !sample.contact.right || sample.dq.norm() > 0.0) continue;
    // A tenth of the weight at a hand.
    const Vec3 hand = sample.q.head<3>() + Vec3(0.0, 0.5 * height_, 0.0);
    kinematics_.set(sample.q);
    const Wrench total = ground_wrench(kinematics_, sample.force);
    const Vec3 weight(0, 0, 0.1 * weight_);
    Wrench loaded = total;
    loaded.force += weight;
    loaded.moment += hand.cross(weight);
    const Moment with_load = moment(sample, share_wrench(robot_, sample.sole, sample.contact, loaded));
    const BySide<Wrench> found = estimate(with_load, with_load.torque, sample.contact);
    Wrench felt;
    for (const Side side : kSides) {
      const Vec3 force = sample.sole[side].R * found[side].force;
      felt.force += force;
      felt.moment += sample.sole[side].R * found[side].moment + sample.sole[side].p.cross(force);
    }
    const double z = support_plane(sample.sole, sample.contact);
    const double shift = (loaded.zmp(z) - total.zmp(z)).norm();
    ASSERT_GT(shift, 0.02 * height_);
    EXPECT_GT((felt.zmp(z) - total.zmp(z)).norm(), 0.8 * shift);
  }
}

TEST_P(SoleWrenchesTest, WhatIsNotFiniteGivesZero) {
  const Moment& moment = moments_.front();
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    VecX torque = moment.torque;
    torque[robot_.leg(Side::left).front()] = value;
    const BySide<Wrench> found = estimate(moment, torque, moment.planned.contact);
    for (const Side side : kSides)
      EXPECT_EQ(found[side], Wrench{});
  }
}

}  // namespace
}  // namespace baton
