#include "baton/balance/sole_wrenches.hpp"

#include <gtest/gtest.h>

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
        add(motion->samples[k], share_wrench_of(motion->samples[k]));
    }
  }

  BySide<Wrench> share_wrench_of(const MotionSample& sample) {
    kinematics_.set(sample.q);
    return share_wrench(robot_, sample.sole, sample.contact, ground_wrench(kinematics_, sample.force));
  }

  /// @param shared wrench on each sole, about the origin
  void add(const MotionSample& sample, const BySide<Wrench>& shared) {
    Moment moment{sample, {}, VecX(robot_.nv() - 6)};
    kinematics_.set(sample.q);
    joint_torques(kinematics_, sample.force, shared, moment.torque);
    for (Eigen::Index j = 0; j < moment.torque.size(); ++j)
      moment.torque[j] += robot_.joints()[static_cast<std::size_t>(j)].motor.damping * sample.dq[6 + j];
    for (const Side side : kSides) {
      const Pose sole = kinematics_.sole(side);
      const Mat3 axes = sole.R.transpose();
      moment.sole[side] = {axes * shared[side].force, axes * shared[side].moment_about(sole.p)};
    }
    moments_.push_back(std::move(moment));
  }

  BySide<Wrench> estimate(const Moment& moment, const VecX& torque, const BySide<bool>& planned,
                          const Vec3& push = Vec3::Zero()) {
    const MotionSample& sample = moment.planned;
    return wrenches_.estimate(
        {sample.q, sample.dq, sample.ddq.head<3>() + push, sample.ddq.segment<3>(3), sample.ddq.tail(robot_.nv() - 6)},
        torque, planned, kinematics_);
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
    const MotionSample& sample = moment.planned;
    const BySide<Wrench> found = wrenches_.by_legs(
        {sample.q, sample.dq, sample.ddq.head<3>(), sample.ddq.segment<3>(3), sample.ddq.tail(robot_.nv() - 6)},
        moment.torque, kinematics_);
    for (const Side side : kSides) {
      EXPECT_LT((found[side].force - moment.sole[side].force).norm(), 1e-6 * weight_);
      EXPECT_LT((found[side].moment - moment.sole[side].moment).norm(), 1e-6 * weight_ * height_);
    }
  }
}

TEST_P(SoleWrenchesTest, FrictionDoesNotHideWhichSoleStands) {
  test::Random random(1);
  for (const Moment& moment : moments_) {
    const VecX torque = with_friction(moment.torque, random);
    const BySide<Wrench> found = estimate(moment, torque, moment.planned.contact);
    Vec3 total = Vec3::Zero();
    for (const Side side : kSides) {
      if (!moment.planned.contact[side]) {
        EXPECT_LT(found[side].force.norm(), 0.25 * weight_);
      }
      total += moment.planned.sole[side].R * (found[side].force - moment.sole[side].force);
    }
    EXPECT_LT(total.norm(), 0.02 * weight_) << "acceleration tells the total";
  }
}

TEST_P(SoleWrenchesTest, AFootThatTouchesTheGroundTooEarlyIsFelt) {
  for (std::size_t k = 0; k < moments_.size(); ++k) {
    const MotionSample sample = moments_[k].planned;
    if (sample.contact.left && sample.contact.right) continue;
    const Side down = sample.contact.left ? Side::left : Side::right;
    BySide<Wrench> shared = share_wrench_of(sample);
    const Wrench whole = shared[down];
    Wrench early;  // of the other foot, with a fifth of the weight, at its centre
    early.force = Vec3(0, 0, 0.2 * weight_);
    early.moment = sample.sole[other(down)].p.cross(early.force);
    shared[other(down)] = early;
    shared[down] = {whole.force - early.force, whole.moment - early.moment};
    add(sample, shared);
    const Moment moment = moments_.back();
    moments_.pop_back();
    const double load = estimate(moment, moment.torque, sample.contact)[other(down)].force.z();
    EXPECT_GT(load, 0.1 * weight_);
    EXPECT_LT(load, 0.25 * weight_);
  }
}

TEST_P(SoleWrenchesTest, APushIsNotTakenForTheGroundWhole) {
  for (std::size_t k = 0; k < moments_.size(); k += 10) {
    const Moment& moment = moments_[k];
    // The trunk is pushed by a third of the weight: the acceleration shows it, the legs do not.
    const Vec3 push(0.3 * kGravity, 0, 0);
    const BySide<Wrench> found = estimate(moment, moment.torque, moment.planned.contact, push);
    for (const Side side : kSides)
      EXPECT_LT((found[side].force - moment.sole[side].force).norm(), 0.31 * weight_);
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
