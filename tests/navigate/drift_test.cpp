#include "baton/navigate/drift.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "baton/ik/stand.hpp"
#include "tests/guide/commands.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

class DriftTest : public testing::TestWithParam<std::string> {
 protected:
  /// A robot that stands anywhere, `shift` and `turn` from where its motions led, in its heading frame.
  GuideContext astray(const Vec2& shift, double turn) {
    const Pose at = random_.upright();
    const Posture posture = stand(robot_, at, robot_.profile().stance.com_height);
    GuideContext context{posture, random_.upright(), Side::left, posture.sole};
    const Mat3 R = rotation_z(turn);
    const Vec3 aside = rotation_z(posture.heading()) * Vec3(shift.x(), shift.y(), 0);
    context.slip_free_frame = context.anchor * Pose{posture.com + aside - R * posture.com, R};
    return context;
  }

  static double beyond(double value, double band, double most) {
    return std::copysign(std::clamp(std::abs(value) - band, 0.0, most), value);
  }

  const RobotModel& robot_ = test::robot(GetParam());
  test::Random random_{5};
};

INSTANTIATE_TEST_SUITE_P(Robots, DriftTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(DriftTest, IsCorrectedAlongAndAsideEachByALittle) {
  const Profile& profile = robot_.profile();
  const double most = 0.05 * profile.reach.trunk;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vec2 shift = Vec2(random_(-0.3, 0.3), random_(-0.03, 0.03)) * profile.stance.com_height;
    const double turn = random_(-0.03, 0.03);
    const GuideContext context = astray(shift, turn);
    const Pose correction = drift_correction(robot_, context, test::push(Part::trunk, 0));
    const Vec3 moved = correction * context.from.com - context.from.com;
    const Vec3 corrected = rotation_z(-context.from.heading()) * moved;
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_NEAR(corrected[axis], beyond(shift[axis], 0.006 * profile.stance.com_height, most), 1e-12)
          << "whatever the other axis has to correct";
    }
    EXPECT_NEAR(yaw_of(correction.R), beyond(turn, 3e-3, 0.05 * profile.reach.rotation), 1e-12);
    for (const Part other : {Part::left_foot, Part::right_hand}) {
      const Pose none = drift_correction(robot_, context, test::push(other, 0));
      EXPECT_TRUE(none.p.isZero(0.0) && none.R.isIdentity(0.0));
    }
  }
}

TEST_P(DriftTest, WhatEachStepLeavesIsNotChased) {
  for (int trial = 0; trial < 1000; ++trial) {
    const double size = robot_.profile().stance.com_height;
    const GuideContext context =
        astray(Vec2(random_(-0.006, 0.006), random_(-0.006, 0.006)) * size, random_(-0.003, 0.003));
    const Pose correction = drift_correction(robot_, context, test::push(Part::trunk, 0));
    EXPECT_TRUE(correction.R.isIdentity(0.0));
    EXPECT_LT(correction.p.norm(), 1e-12);
  }
}

}  // namespace
}  // namespace baton
