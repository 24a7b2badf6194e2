/// What an operator reads on the page.
#include "baton/proving/page.hpp"

#include <gtest/gtest.h>

#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

class PageTest : public testing::Test {
 protected:
  /// Holds the stick for so long [s].
  /// @returns whether a page read meanwhile was so
  template <typename So>
  bool hold(const Command& command, double time, So so) {
    bool seen = false;
    for (const double end = session_.t() + time; session_.t() < end;) {
      session_.step(command);
      page_ = reader_.read(session_.view());
      EXPECT_DOUBLE_EQ(page_.t, session_.t());
      seen = seen || so();
    }
    return seen;
  }
  void hold(const Command& command, double time) {
    hold(command, time, [] { return false; });
  }

  static Command trunk(int axis, double deflection) {
    Command command;
    command.axes[axis] = deflection;
    return command;
  }

  const World world_ = World::load("flat");
  Simulation simulation_{
      test::robot("mighty"), world_, Simulation::On::ideal, {.session = {.modes = {.on_limit = OnLimit::discard}}}};
  Session& session_ = simulation_.session();
  PageReader reader_;
  Page page_;
};

TEST_F(PageTest, ItShowsWhatTheRobotDoesAndWhichFeetStand) {
  hold({}, 0.1);
  EXPECT_EQ(page_.activity, Activity::rest);
  EXPECT_TRUE(page_.contact.left && page_.contact.right);
  EXPECT_TRUE(hold(trunk(0, 1.0), 2.0, [&] { return page_.activity == Activity::moving; }));
  EXPECT_TRUE(hold(trunk(0, 1.0), 2.0, [&] { return !page_.contact.left; }));
  EXPECT_TRUE(hold(trunk(0, 1.0), 2.0, [&] { return !page_.contact.right; }));
  Command stop;
  stop.recall = Recall::stop;
  EXPECT_TRUE(hold(stop, 0.1, [&] { return page_.activity == Activity::stopping; }));
  hold({}, 3.0);
  EXPECT_EQ(page_.activity, Activity::rest);
  EXPECT_EQ(page_.refusals, 0);
}

TEST_F(PageTest, ItCountsRefusalsAHeldStickOnce) {
  const Command too_high = trunk(2, 1.0);
  hold(too_high, 5.0);  // first it rises
  EXPECT_EQ(page_.refusals, 1);
  EXPECT_EQ(page_.activity, Activity::rest);
  hold({}, 0.2);
  hold(too_high, 1.0);
  EXPECT_EQ(page_.refusals, 2);
}

TEST(Page, ItSaysThatAMotionDoesOnlyPartOfTheRequest) {
  const World world = World::load("flat");
  Simulation simulation(test::robot("mighty"), world, Simulation::On::ideal);
  PageReader reader;
  Command command{.guide = Part::left_foot};
  command.axes[1] = 1.0;  // as far aside as the leg reaches
  bool limited = false;
  for (int i = 0; i < 600; ++i) {
    simulation.session().step(command);
    limited = limited || reader.read(simulation.session().view()).limited;
  }
  EXPECT_TRUE(limited);
}

}  // namespace
}  // namespace baton
