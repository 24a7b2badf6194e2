#include "baton/model/limits.hpp"

#include <gtest/gtest.h>

#include "tests/support/robots.hpp"

namespace baton {
namespace {

class LimitsTest : public testing::TestWithParam<std::string> {
 protected:
  const Profile& profile_ = test::robot(GetParam()).profile();
  const Limits normal_ = Limits::normal(profile_);
};

INSTANTIATE_TEST_SUITE_P(Robots, LimitsTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(LimitsTest, UnevenGroundKeepsThePlannedZmpFartherInsideButWhereAComMayRest) {
  Limits uneven = Limits::uneven_ground(profile_);
  EXPECT_GT(uneven.zmp_plan, normal_.zmp_plan);
  EXPECT_LE(uneven.zmp_plan, profile_.margin.stand_on);
  uneven.zmp_plan = normal_.zmp_plan;
  EXPECT_EQ(uneven, normal_);
}

TEST_P(LimitsTest, AStepThatCatchesTheRobotKeepsWhatTheNextMotionNeeds) {
  Limits push = Limits::push_recovery(profile_);
  EXPECT_LE(push.zmp_plan, normal_.zmp_plan);
  EXPECT_GE(push.zmp_plan, push.zmp_verify);
  EXPECT_EQ(push.zmp_outward, push.zmp_plan);
  EXPECT_EQ(push.torque, 1.0);
  EXPECT_GT(push.heat, normal_.heat);
  EXPECT_GT(push.acceleration, normal_.acceleration);
  EXPECT_LT(push.swing_clearance, normal_.swing_clearance);
  EXPECT_LT(push.swing_time, normal_.swing_time);
  push.zmp_plan = normal_.zmp_plan;
  push.zmp_outward = normal_.zmp_outward;
  push.torque = normal_.torque;
  push.heat = normal_.heat;
  push.acceleration = normal_.acceleration;
  push.swing_clearance = normal_.swing_clearance;
  push.swing_time = normal_.swing_time;
  EXPECT_EQ(push, normal_) << "joints, distances, edges and friction";
}

}  // namespace
}  // namespace baton
