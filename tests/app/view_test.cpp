/// What the page is told that the robot does.
#include "app/view.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/robots.hpp"

namespace baton {
namespace {

class ViewTest : public testing::Test {
 protected:
  /// Holds the stick for so long [s]; what the robot did meanwhile.
  std::set<Activity> hold(const Command& command, double time) {
    std::set<Activity> seen;
    for (const double end = session_.t() + time; session_.t() < end;) {
      session_.step(command);
      refusals_.look(session_.navigator());
      view_.show(simulation_, {}, refusals_);
      seen.insert(activity(session_.navigator(), session_.fallen()));
    }
    return seen;
  }
  [[nodiscard]] Activity now() const { return activity(session_.navigator(), session_.fallen()); }

  static Command walk() {
    Command command;
    command.axes[0] = 1.0;
    return command;
  }

  using Seen = std::set<Activity>;
  const World world_ = World::load("flat");
  Simulation simulation_{test::robot("mighty"), world_, Simulation::On::ideal};
  Session& session_ = simulation_.session();
  app::View view_{simulation_, 0, false};
  app::Refusals refusals_;
};

TEST_F(ViewTest, ARobotRestsMovesStopsAndRetraces) {
  EXPECT_EQ(hold({}, 0.1), Seen{Activity::rest});
  hold(walk(), 0.2);
  EXPECT_EQ(hold(walk(), 2.0), Seen{Activity::moving});
  EXPECT_EQ(hold({.recall = Recall::stop}, 3.0), (Seen{Activity::stopping, Activity::rest}));
  EXPECT_EQ(now(), Activity::rest) << "though it is held";
  hold({}, 0.1);
  EXPECT_EQ(hold({.recall = Recall::retrace}, 1.0), (Seen{Activity::rest, Activity::retracing}));
  hold({.recall = Recall::retrace}, 9.0);
  EXPECT_EQ(now(), Activity::rest) << "nothing is left, though it is held";
}

TEST_F(ViewTest, GoingHomeIsAWayBackAndAWalkThatEndsBeforeIsNot) {
  Command apart{.guide = Part::left_foot};
  apart.axes[0] = apart.axes[1] = 1.0;
  hold(apart, 0.3);
  ASSERT_EQ(now(), Activity::moving);
  Seen before;
  while (session_.navigator().committed() == 1)
    before.merge(hold({.recall = Recall::home}, 0.005));
  EXPECT_EQ(now(), Activity::retracing);
  before.erase(Activity::retracing);
  EXPECT_EQ(before, Seen{Activity::moving});
  hold({}, 0.02);
  EXPECT_EQ(now(), Activity::retracing) << "let go of, it ends what it began";
  hold({}, 2.0);
  EXPECT_EQ(now(), Activity::rest);
}

TEST_F(ViewTest, AWayBackThatIsRefusedIsRest) {
  EXPECT_EQ(hold({.recall = Recall::retrace}, 0.5), Seen{Activity::rest});
  ASSERT_TRUE(refusals_.newest());
  EXPECT_EQ(refusals_.newest()->reason, Reason::no_history);
}

}  // namespace
}  // namespace baton
