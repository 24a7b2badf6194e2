/// A guided foot at an edge of the ground.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton {
namespace {

class StepPastEdgeTest : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Robots, StepPastEdgeTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(StepPastEdgeTest, HoweverFarItIsAFewTapsTakeTheFootThere) {
  const RobotModel& robot = test::robot(GetParam());
  const Profile& profile = robot.profile();
  const double size = profile.stance.com_height;
  const Posture home = stand(robot, Pose{}, size);
  double toe = 0.0;
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    toe = std::max(toe, vertex.x());
  const auto ticks = [&](double seconds) {
    return std::lround(seconds * std::sqrt(size / 0.26) / profile.tick.period);
  };
  for (const bool down : {true, false}) {
    for (double gap = 0.01; gap < 0.21; gap += 0.02) {
      SCOPED_TRACE(testing::Message() << (down ? "down" : "up") << " after " << gap << " COM heights");
      const double edge = home.sole.left.p.x() + toe + gap * size;
      const double drop = (down ? -0.05 : 0.05) * size;
      const std::string file = test::temp_folder() + "edge.xml";
      std::ofstream(file) << fmt::format(
          R"(<mujoco><worldbody><site name="start"/><geom name="ground" type="box" pos="{} 0 -1" size="9 9 1"/>)"
          R"(<geom name="ground_next" type="box" pos="{} 0 {}" size="9 9 1"/></worldbody></mujoco>)",
          edge - 9.0, edge + 9.0, drop - 1.0);
      test::Trip trip(robot, {}, file);
      Command tap;
      tap.guide = Part::left_foot;
      tap.axes[0] = 1.0;
      int taps = 0;
      long moved = 0;
      const auto past = [&] { return trip.posture().sole.left.p.x() > edge; };
      while (taps < 8 && !past()) {
        ++taps;
        for (long k = ticks(0.2); k > 0; --k)
          trip.step(tap);
        const Command let_go{.guide = Part::left_foot};
        for (long k = ticks(2.5); k > 0; --k)
          trip.step(let_go);
        EXPECT_GT(trip.navigator().committed(), moved) << "tap " << taps << " was in vain";
        moved = trip.navigator().committed();
      }
      EXPECT_TRUE(past()) << taps;
    }
  }
}

}  // namespace
}  // namespace baton
