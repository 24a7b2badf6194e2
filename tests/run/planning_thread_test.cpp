#include "baton/run/planning_thread.hpp"

#include <gtest/gtest.h>

#include "baton/ik/stand.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

TEST(PlanningThread, AnswersAsPlanningDoes) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  Strategy strategy(robot, world);
  Request request;
  request.start.context.from = stand(robot, world.site("start"), robot.profile().stance.com_height);
  request.start.context.foothold = request.start.context.from.sole;
  request.start.posture = request.start.context.from;
  PlanningThread thread(robot, world, {});
  for (const double x : {1.0, -0.5, 0.0, 0.3}) {
    request.command.axes[0] = x;
    ASSERT_TRUE(thread.idle());
    EXPECT_FALSE(thread.poll(0).has_value());
    thread.post(request);
    std::optional<Planning::Reply> answer;
    while (!(answer = thread.poll(0)))
      std::this_thread::yield();
    const Answer expected = strategy.plan(request);
    ASSERT_EQ(answer->answer.outcome.index(), expected.outcome.index());
    if (const Motion* motion = expected.motion()) {
      const Motion& other = *answer->answer.motion();
      ASSERT_EQ(other.ticks(), motion->ticks());
      EXPECT_EQ(other.end.q, motion->end.q);
    }
  }
  thread.post(request);
  thread.reset();
  EXPECT_TRUE(thread.idle());
  EXPECT_FALSE(thread.poll(0)) << "the answer is dropped";
  thread.post(request);  // and it ends well with a request in hand
}

}  // namespace
}  // namespace baton
