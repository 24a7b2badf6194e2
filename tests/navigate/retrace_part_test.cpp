/// A way back that cannot be taken whole.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "baton/model/contact.hpp"
#include "baton/plan/planner.hpp"
#include "baton/plan/retrace.hpp"
#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton {
namespace {

class RetracePartTest : public testing::TestWithParam<std::string> {
 protected:
  /// The floor from `x` on only: what lies behind has been taken away [m].
  static World floor_from(double x) {
    const std::string file = test::temp_folder() + "floor.xml";
    std::ofstream(file) << fmt::format(
        R"(<mujoco><worldbody><site name="start"/><geom name="ground" type="box" pos="{} 0 -1" size="9 9 1"/>)"
        R"(</worldbody></mujoco>)",
        x + 9.0);
    return World{file};
  }

  static void come_to_rest(test::Trip& trip) {
    for (int k = 0; k < 4000 && trip.navigator().motion() != nullptr; ++k)
      trip.step({});
    ASSERT_EQ(trip.navigator().motion(), nullptr);
  }

  static Command retrace() {
    Command command;
    command.recall = Recall::retrace;
    return command;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const double height_ = robot_.profile().stance.com_height;
};

INSTANTIATE_TEST_SUITE_P(Robots, RetracePartTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(RetracePartTest, GoesToTheLastRestBeforeWhatCannotBeTakenBack) {
  test::Trip trip(robot_);
  Command walk;
  walk.axes[0] = 1.0;
  walk.axes[5] = 0.1;
  const double period = robot_.profile().tick.period;
  for (double t = 0.0; t < 6.0 * std::sqrt(height_ / 0.26); t += period)
    trip.step(walk);
  come_to_rest(trip);
  const Request request = trip.navigator().request_for(retrace());
  ASSERT_TRUE(request.start.trail);
  const double here = request.start.posture.com.x();
  ASSERT_GT(here, 0.8 * height_);
  const double stride = robot_.profile().region.foot_x.hi;

  int parts = 0;
  double end_before = -1.0;
  for (double x = -1.5 * height_; x < here + 0.1 * height_; x += 0.07 * height_) {
    SCOPED_TRACE(testing::Message() << "floor from " << x << " of " << here);
    const World world = floor_from(x);
    Strategy strategy(robot_, world);
    const Answer result = strategy.plan(request);
    const auto* planned = std::get_if<PlannedMotion>(&result.outcome);
    if (planned == nullptr) {
      EXPECT_EQ(std::get<Refusal>(result.outcome).reason, Reason::ground);
      EXPECT_GT(x, here - 3.0 * stride) << "there were rests on the way";
      continue;
    }
    const VerifiedMotion& motion = planned->motion;
    EXPECT_TRUE(motion->retraces);
    const auto verdict =
        Verifier(robot_, world).verify(*motion, request.start.context.anchor, Limits::normal(robot_.profile()));
    EXPECT_TRUE(std::holds_alternative<VerifiedMotion>(verdict));
    EXPECT_TRUE(motion->samples.front().dq.isZero(0.0) && motion->samples.back().dq.isZero(0.0));
    EXPECT_GE(motion->end.com.x(), end_before) << "more floor, and not so far";
    end_before = motion->end.com.x() - 1e-9;
    if (!planned->limit) {
      EXPECT_EQ(motion->end.q, request.start.trail->start.q);
      continue;
    }
    ++parts;
    EXPECT_EQ(planned->limit->reason, Reason::ground);
    EXPECT_TRUE(motion->end.contact.left && motion->end.contact.right);
    EXPECT_LT(motion->end.com.x() - x, 3.0 * stride) << "it could have gone farther";
    // What is left of the way back goes on from there, to the bit.
    const Motion left = reversed(robot_, *result.trail);
    EXPECT_EQ(left.samples.front().q, motion->end.q);
    EXPECT_EQ(left.end.q, request.start.trail->start.q);
    // Where commands are not done in part, it is refused.
    Strategy strict(robot_, world, {.on_limit = OnLimit::discard});
    EXPECT_TRUE(std::holds_alternative<Refusal>(strict.plan(request).outcome));
  }
  EXPECT_GT(parts, 8);
}

TEST_P(RetracePartTest, KeepsTheZmpFromOuterEdgesWhereverTheRobotSeemsToWeigh) {
  test::Trip trip(robot_);
  Command walk;
  walk.axes[0] = 1.0;
  const double period = robot_.profile().tick.period;
  for (double t = 0.0; t < 4.0 * std::sqrt(height_ / 0.26); t += period)
    trip.step(walk);
  come_to_rest(trip);
  const Request request = trip.navigator().request_for(retrace());
  ASSERT_TRUE(request.start.trail);
  const World world = World::load("flat");
  Planner planner(robot_, world, DurationRule::paper);
  int back = 0;
  int refused = 0;
  for (int k = -20; k <= 20; ++k) {
    Limits limits = Limits::normal(robot_.profile());
    limits.zmp_outward = 1.5 * robot_.sole_half_width();  // so that a quarter is more than what the verifier asks for
    limits.com_offset = {0.0, 0.005 * height_ * k};
    const PlanResult result =
        planner.retrace(*request.start.trail, request.start.context.anchor, limits, request.start.posture.heat);
    const auto* planned = std::get_if<PlannedMotion>(&result);
    if (planned == nullptr) {
      ++refused;
      EXPECT_EQ(std::get<Refusal>(result).reason, Reason::zmp) << k;
      EXPECT_NE(k, 0);
      continue;
    }
    ++back;
    for (const MotionSample& sample : planned->motion->samples) {
      const Vec2 zmp = sample.zmp + limits.com_offset;
      for (const Side side : kSides) {
        if (!sample.contact[side]) continue;
        const ConvexPolygon outline = sole_outline(robot_, side, sample.sole[side]);
        const Vec2 outward = sign_of(side) * (sample.sole[side].R * Vec3::UnitY()).head<2>().normalized();
        double edge = -1e9;
        for (const Vec2& corner : outline.vertices())
          edge = std::max(edge, outward.dot(corner));
        ASSERT_GE(edge - outward.dot(zmp), 0.24 * limits.zmp_outward) << k;
      }
    }
  }
  EXPECT_GT(back, 3);
  EXPECT_GT(refused, 3);
}

TEST_P(RetracePartTest, LetGoOfOnTheWayItRestsWhereItCanAndTheRestOfTheWayStaysKnown) {
  test::Trip trip(robot_);
  Command walk;
  walk.axes[0] = 1.0;
  const double period = robot_.profile().tick.period;
  const auto ticks = [&](double seconds) { return std::lround(seconds * std::sqrt(height_ / 0.26) / period); };
  // With rests between its steps, too: up and down it goes where it stands.
  for (long k = 0; k < ticks(8.0); ++k) {
    const bool bobs = k % ticks(2.0) > ticks(1.2);
    Command command = walk;
    if (bobs) command.axes << 0, 0, k % ticks(0.4) < ticks(0.2) ? 0.9 : -0.9, 0, 0, 0;
    trip.step(command);
  }
  come_to_rest(trip);
  const Posture home = trip.home();
  const World world = floor_from(home.sole.left.p.x() + 0.2 * height_);
  Strategy strategy(robot_, world);
  Navigator& navigator = trip.navigator();
  const auto step = [&](const Command& command, Strategy& planner) {
    trip.body().write(navigator.tick(trip.body().read(), command));
    navigator.poll();
    if (const auto request = navigator.request()) navigator.answer(planner.plan(*request));
  };
  // Again and again it is let go of on its way to the edge of the floor.
  for (int press = 0; press < 12; ++press) {
    for (long k = ticks(0.3 + 0.13 * press); k > 0; --k)
      step(retrace(), strategy);
    for (long k = ticks(4.0); k > 0 && (k > ticks(3.9) || navigator.motion() != nullptr); --k)
      step({}, strategy);
    ASSERT_EQ(navigator.motion(), nullptr);
    ASSERT_GE(navigator.history(), 1u);
  }
  step(retrace(), strategy);
  ASSERT_EQ(navigator.motion(), nullptr) << "at the edge it has come as far as it can";
  // With the floor there again, all the way home.
  for (long k = ticks(0.2); k > 0; --k)
    step({}, strategy);
  for (long k = ticks(30.0); k > 0 && (navigator.history() > 0 || navigator.motion() != nullptr); --k)
    step(retrace(), trip.strategy());
  EXPECT_EQ(navigator.history(), 0u);
  for (const Side side : kSides)
    EXPECT_LT((trip.posture().sole[side].p - home.sole[side].p).norm(), 1e-4);
}

}  // namespace
}  // namespace baton
