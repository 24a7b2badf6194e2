// A robot that falls, is stood up again, or is lifted off the ground.
#include <gtest/gtest.h>

#include <functional>

#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/turned_imu.hpp"

namespace baton {
namespace {

using test::Trip;

class GuardTest : public testing::TestWithParam<std::string> {
 protected:
  /// Ticks with what the ideal robot measures, changed, and `command`, planned for.
  template <typename Change>
  void tick(double seconds, const Command& command, Change change) {
    for (long k = std::lround(seconds / robot_.profile().tick.period); k > 0; --k) {
      Measurement measurement = trip_.body().read();
      change(measurement);
      noise_ = 1e-9 - noise_;  // measurements are never the same twice
      measurement.q.array() += noise_;
      measurement.imu.rate.array() += noise_;
      const JointTarget& target = trip_.navigator().tick(measurement, command);
      soft_ = target.tau.isZero(0.0) && target.dq.isZero(0.0) && target.q == measurement.q;
      trip_.navigator().poll();
      if (const auto request = trip_.navigator().request()) trip_.navigator().answer(trip_.strategy().plan(*request));
    }
  }
  void tick(double seconds, const Command& command) { tick(seconds, command, leaning(0.0)); }

  /// Its joints are elsewhere: the whole body leans forward over its ankles, its DCM 0.03 COM heights off.
  /// @param holds the ZMP goes far enough to hold it
  [[nodiscard]] std::function<void(Measurement&)> pushed(bool holds = true) { return leaning(0.03, holds); }

  /// It leans by that angle soon, and all sensors agree.
  /// @param speed [rad/s]
  [[nodiscard]] std::function<void(Measurement&)> leaning(double angle, bool holds = true, double speed = 0.25) {
    return [this, angle, holds, speed](Measurement& m) {
      lean_.apply(m, angle, speed);
      if (lean_.angle() == 0.0) return;
      // Else the ZMP goes the other way, as that of soles that tip over an edge.
      const double zmp = (holds ? 1.3 * lean_.angle() : -0.15) * robot_.profile().stance.com_height;
      for (const Side side : kSides)
        m.sole[side].moment.y() -= zmp * m.sole[side].force.z();
    };
  }

  /// The robot tips onto its face within 0.1 s, and lies there: all of the IMU agrees.
  [[nodiscard]] auto tip() const {
    return [angle = 0.0, period = robot_.profile().tick.period](Measurement& m) mutable {
      const double rate = angle < 1.0 ? 10.0 : 0.0;
      angle += rate * period;
      test::turn_imu(m, rotation_exp(Vec3(0.0, angle, 0.0)));
      m.imu.rate += m.imu.attitude.transpose() * Vec3(0.0, rate, 0.0);
    };
  }
  static void lift(Measurement& m) { m.sole = {}; }

  [[nodiscard]] static Command forward() {
    Command command;
    command.axes[0] = 1.0;
    return command;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  Trip trip_{robot_};
  bool soft_ = false;
  double noise_ = 0.0;
  test::Lean lean_{robot_};
};

INSTANTIATE_TEST_SUITE_P(Robots, GuardTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(GuardTest, AFallClearsThePlanAndTheMotorsGoSoft) {
  tick(0.3, {});
  EXPECT_EQ(trip_.navigator().guard(), Guard::armed);
  tick(0.2, {}, tip());
  EXPECT_EQ(trip_.navigator().guard(), Guard::fallen);
  const long before = trip_.navigator().committed();
  tick(0.5, forward());
  EXPECT_EQ(trip_.navigator().guard(), Guard::fallen);
  EXPECT_EQ(trip_.navigator().phase(), Phase::fallen);
  EXPECT_EQ(trip_.navigator().motion(), nullptr);
  EXPECT_EQ(trip_.navigator().committed(), before);
  EXPECT_TRUE(soft_);
}

TEST_P(GuardTest, StoodUpAgainItIsArmedFromACentredStickOnly) {
  tick(0.3, {});
  tick(0.2, {}, tip());
  const long before = trip_.navigator().committed();
  tick(0.5, {});
  EXPECT_EQ(trip_.navigator().guard(), Guard::fallen) << "it has to stand still for a while first";
  tick(2.0, forward());
  EXPECT_EQ(trip_.navigator().guard(), Guard::stood_up);
  EXPECT_TRUE(soft_);
  EXPECT_EQ(trip_.navigator().committed(), before);
  tick(0.05, {});
  EXPECT_EQ(trip_.navigator().guard(), Guard::armed);
  EXPECT_FALSE(soft_);
  EXPECT_EQ(trip_.navigator().history(), 0u) << "what was done before the fall does not lead back";
  tick(0.2, forward());
  EXPECT_GT(trip_.navigator().committed(), before);
}

TEST_P(GuardTest, NotStoodUpWellItStaysSoft) {
  tick(0.2, {}, tip());
  // Upright, but one foot carries nothing.
  tick(3.0, {}, [](Measurement& m) { m.sole.left = {}; });
  EXPECT_EQ(trip_.navigator().guard(), Guard::fallen);
  EXPECT_TRUE(soft_);
}

TEST_P(GuardTest, LiftedOffTheGroundItDoesNotWalkInTheAir) {
  tick(0.3, {});
  tick(0.3, {}, lift);
  EXPECT_EQ(trip_.navigator().guard(), Guard::lifted);
  tick(1.0, forward(), lift);
  tick(1.0, forward());
  EXPECT_EQ(trip_.navigator().committed(), 0) << "put down, but the stick was not let go of";
  tick(0.3, {});
  EXPECT_EQ(trip_.navigator().guard(), Guard::armed);
  tick(0.2, forward());
  EXPECT_GE(trip_.navigator().committed(), 1);
}

TEST_P(GuardTest, WhoIsPushedBeginsNothingUntilItIsBack) {
  tick(0.3, {});
  tick(0.1, {}, pushed());
  ASSERT_TRUE(trip_.navigator().disturbed());
  tick(1.0, forward(), pushed());
  EXPECT_EQ(trip_.navigator().committed(), 0);
  tick(0.5, {});
  EXPECT_FALSE(trip_.navigator().disturbed());
  tick(0.1, forward());
  EXPECT_GE(trip_.navigator().committed(), 1);
}

TEST_P(GuardTest, WhoIsPushedWhileAnAnswerIsAwaitedDoesNotBeginWhatItBrings) {
  tick(0.3, {});
  Navigator& navigator = trip_.navigator();
  navigator.tick(trip_.body().read(), forward());
  navigator.poll();
  const std::optional<Request> request = navigator.request();
  ASSERT_TRUE(request);
  navigator.answer(trip_.strategy().plan(*request));
  while (navigator.now() < request->at) {
    Measurement measurement = trip_.body().read();
    leaning(0.03, true, 2.0)(measurement);  // a jolt, which the specific force does not show
    navigator.tick(measurement, forward());
    navigator.poll();
  }
  EXPECT_TRUE(navigator.disturbed());
  EXPECT_GT(navigator.dcm_error().norm(), 0.02 * robot_.profile().stance.com_height);
  EXPECT_EQ(navigator.committed(), 0);
  tick(0.5, {});
  tick(0.1, forward());
  EXPECT_GE(navigator.committed(), 1);
}

TEST_P(GuardTest, AWayBackThatASlipEndsWhileItIsPlannedIsNotTaken) {
  Trip trip(robot_, {}, "flat", StateSource::perfect);
  for (int k = 0; k < 1200; ++k)
    trip.step(k < 200 ? forward() : Command{});
  Navigator& navigator = trip.navigator();
  ASSERT_EQ(navigator.motion(), nullptr);
  ASSERT_GE(navigator.history(), 1u);
  const long before = navigator.committed();
  Command back;
  back.recall = Recall::retrace;
  navigator.tick(trip.body().read(), back);
  navigator.poll();
  const std::optional<Request> request = navigator.request();
  ASSERT_TRUE(request);
  navigator.answer(trip.strategy().plan(*request));
  while (navigator.now() <= request->at) {
    Measurement measurement = trip.body().read();
    measurement.root->pose.p.x() += 0.4 * robot_.profile().reach.foot;
    navigator.tick(measurement, back);
    navigator.poll();
  }
  EXPECT_EQ(navigator.slips(), 1);
  EXPECT_EQ(navigator.history(), 0u);
  EXPECT_EQ(navigator.committed(), before);
}

TEST_P(GuardTest, NothingBeginsThatWasAskedForBeforeAStop) {
  for (const bool tapped : {true, false}) {
    tick(1.0, {});
    Navigator& navigator = trip_.navigator();
    const long before = navigator.committed();
    navigator.tick(trip_.body().read(), forward());
    navigator.poll();
    const std::optional<Request> request = navigator.request();
    ASSERT_TRUE(request);
    navigator.answer(trip_.strategy().plan(*request));
    Command stop;
    stop.recall = Recall::stop;
    navigator.tick(trip_.body().read(), stop);
    navigator.poll();
    while (navigator.now() < request->at)
      navigator.tick(trip_.body().read(), tapped ? forward() : stop);
    EXPECT_EQ(navigator.committed(), before);
  }
}

TEST_P(GuardTest, WhoIsPushedDoesNotLiftTheFootThatWasToStep) {
  tick(0.3, {});
  for (int k = 0; k < 400 && (trip_.navigator().motion() == nullptr || !trip_.navigator().motion()->goal.swing); ++k)
    tick(robot_.profile().tick.period, forward());
  ASSERT_NE(trip_.navigator().motion(), nullptr);
  ASSERT_TRUE(trip_.navigator().motion()->goal.swing);
  ASSERT_EQ(trip_.navigator().phase(), Phase::double_support);
  for (int k = 0; k < 200; ++k) {
    tick(robot_.profile().tick.period, forward(), pushed());
    ASSERT_TRUE(trip_.navigator().phase() == Phase::double_support || trip_.navigator().phase() == Phase::hold) << k;
  }
  EXPECT_EQ(trip_.navigator().phase(), Phase::hold);
  EXPECT_EQ(trip_.navigator().caught(), 0);
  EXPECT_EQ(trip_.navigator().sample().contact.left && trip_.navigator().sample().contact.right, true);
}

TEST_P(GuardTest, WhoIsPushedSoThatNoZmpHoldsItSteps) {
  tick(0.3, {});
  tick(0.5, {}, pushed());
  EXPECT_EQ(trip_.navigator().caught(), 0);
  tick(0.5, {});
  tick(0.5, {}, pushed(false));
  EXPECT_GE(trip_.navigator().caught(), 1) << "the ground does not give the moment that would hold it";
}

}  // namespace
}  // namespace baton
