#include "baton/model/place_margins.hpp"

#include <gtest/gtest.h>

#include "tests/support/robots.hpp"

namespace baton {
namespace {

class PlaceMarginsTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Profile& profile_ = robot_.profile();
  const double size_ = profile_.stance.com_height;
};

INSTANTIATE_TEST_SUITE_P(Robots, PlaceMarginsTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(PlaceMarginsTest, WhoKnowsItsPlaceKeepsTheMarginsOfTheProfile) {
  EXPECT_EQ(edge_margin(robot_, 0.0), profile_.margin.edge);
  EXPECT_EQ(obstacle_uncertainty(robot_, 0.0), 0.0);
}

TEST_P(PlaceMarginsTest, GrowWithTheUncertaintyAsFarAsOneCanLiveWithThem) {
  double length = 0.0;
  for (const Vec2& vertex : robot_.sole(Side::left).vertices())
    length = std::max(length, 2.0 * vertex.x());
  double edge = edge_margin(robot_, 0.0);
  double obstacle = obstacle_uncertainty(robot_, 0.0);
  for (int k = 1; k <= 10000; ++k) {
    const double unsure = 1e-4 * k * size_;
    EXPECT_GE(edge_margin(robot_, unsure), edge);
    EXPECT_GE(obstacle_uncertainty(robot_, unsure), obstacle);
    edge = edge_margin(robot_, unsure);
    obstacle = obstacle_uncertainty(robot_, unsure);
    // A sole still steps from one side of an edge to the other.
    EXPECT_LT(length + 2.0 * edge, profile_.region.foot_x.hi);
    EXPECT_LE(obstacle, 0.1 * size_);
  }
  EXPECT_GT(edge, profile_.margin.edge);
  EXPECT_EQ(obstacle, 0.1 * size_);
}

}  // namespace
}  // namespace baton
