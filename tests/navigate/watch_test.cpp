#include "baton/navigate/watch.hpp"

#include <gtest/gtest.h>

#include "baton/ik/stand.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

/// A standing robot whose left foot is planned to stand, too.
class WatchTest : public testing::TestWithParam<std::string> {
 protected:
  WatchTest()
      : posture_(stand(robot_, Pose{}, robot_.profile().stance.com_height)),
        planned_(resting(robot_, posture_)),
        watch_(robot_, world_, StateSource::perfect, posture_) {
    const int n = robot_.nv() - 6;
    measurement_.q = posture_.q.tail(n);
    measurement_.dq = VecX::Zero(n);
    measurement_.root =
        RootMeasurement{{posture_.q.head<3>(),
                         Eigen::Quaterniond(posture_.q[3], posture_.q[4], posture_.q[5], posture_.q[6]).matrix()}};
  }

  /// @param above height of the left sole above its planned place [COM height]
  /// @param load its share of the weight
  void live(double seconds, double above, double load) {
    const double weight = robot_.mass() * kGravity;
    MotionSample planned = planned_;
    planned.sole.left.p.z() -= above * robot_.profile().stance.com_height;
    measurement_.sole.left.force = load * weight * Vec3::UnitZ();
    measurement_.sole.right.force = (1.0 - load) * weight * Vec3::UnitZ();
    for (long k = std::lround(seconds / robot_.profile().tick.period); k > 0; --k) {
      measurement_.t += robot_.profile().tick.period;
      watch_.estimate(measurement_, planned, Pose{});
      watch_.judge(planned, Pose{}, true);
    }
  }

  const RobotModel& robot_ = test::robot(GetParam());
  World world_ = World::load("flat");
  Posture posture_;
  MotionSample planned_;
  Watch watch_;
  Measurement measurement_;
};

INSTANTIATE_TEST_SUITE_P(Robots, WatchTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(WatchTest, NothingBeginsWhileAFootThatShouldStandHangsInTheAir) {  // it may lie on the other one
  live(0.2, 0.0, 0.5);
  ASSERT_FALSE(watch_.disturbed());
  live(0.02, 0.02, 0.0);
  EXPECT_FALSE(watch_.disturbed()) << "it lands a little late";
  live(0.06, 0.02, 0.0);
  EXPECT_TRUE(watch_.disturbed());
  live(0.01, 0.02, 0.3);
  EXPECT_FALSE(watch_.disturbed()) << "on something that is higher than the map says";
  live(0.5, 0.008, 0.0);
  EXPECT_FALSE(watch_.disturbed()) << "it touches, but carries nothing yet";
}

}  // namespace
}  // namespace baton
