/// What the page is told that the robot does.
#include "app/view.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>
#include <vector>

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

TEST_F(ViewTest, ArmsThatCannotFollowWhatDrivesThemAreAMessage) {
  const RobotModel& robot = session_.model();
  EXPECT_EQ(app::arms_message(session_), "");
  std::vector<std::string> joints;
  std::vector<int> numbers;
  for (const Side side : kSides) {
    for (const int j : robot.arm(side)) {
      joints.push_back(robot.joints()[static_cast<std::size_t>(j)].name);
      numbers.push_back(j);
    }
  }
  Kinematics kinematics(robot);
  VecX q = session_.start().q;
  VecX angles(static_cast<Eigen::Index>(joints.size()));
  std::mt19937_64 random(4);
  do {  // until an arm would be inside another link
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const Range& range = robot.joints()[static_cast<std::size_t>(numbers[k])].position;
      angles[static_cast<Eigen::Index>(k)] = std::uniform_real_distribution<double>(range.lo, range.hi)(random);
      q[7 + numbers[k]] = angles[static_cast<Eigen::Index>(k)];
    }
    kinematics.set(q);
  } while (kinematics.self_distance(0.0) > -0.01);
  session_.drive_arms({joints, {session_.t() + 0.5}, angles.transpose()});
  std::set<std::string> said;
  for (int k = 0; k < 800; ++k) {
    session_.step({});
    said.insert(app::arms_message(session_));
  }
  said.erase("");
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said.begin()->find("The arms cannot follow their targets, or only in part: "), 0U);
  session_.drive_arms(released_arms(robot));
  EXPECT_EQ(app::arms_message(session_), "");
}

}  // namespace
}  // namespace baton
