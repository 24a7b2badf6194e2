/// How a person sees the robot: errors, reaction time, the mean of many looks.
#include "baton/proving/eyes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

constexpr double kSecond = 200;  ///< [ticks]

class EyesTest : public testing::Test {
 protected:
  static Eyes::Parameters eyes(double error, double reaction) {
    Eyes::Parameters parameters = Eyes::Parameters::with_error(error);
    parameters.reaction = reaction;
    return parameters;
  }
  static Command walk() {
    Command command;
    command.axes[0] = 1.0;
    return command;
  }

  const RobotModel& robot_ = test::robot("mighty");
  const World world_ = World::load("flat");
  Simulation simulation_{robot_, world_, Simulation::On::ideal};
  Session& session_ = simulation_.session();
};

/// Of numbers that should have mean 0.
struct Moments {
  double sum = 0.0;
  double squares = 0.0;
  double products = 0.0;  ///< with the same number later
  double count = 0.0;

  void add(double value, double later) {
    sum += value;
    squares += value * value;
    products += value * later;
    count += 1.0;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double sigma() const { return std::sqrt(squares / count); }
  [[nodiscard]] double correlation() const { return products / squares; }
};

TEST_F(EyesTest, EveryCoordinateErrsByTheGivenSigmaAndForASecond) {
  session_.step(Command{});
  Eyes exact(robot_, 0, eyes(0.0, 0.0));
  Sight truth = exact.look(session_.view())->sight;
  const std::array<Place*, 5> places = truth.all();
  Moments position;
  Moments yaw;
  Moments across;  // of one coordinate with the next
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Eyes person(robot_, seed, eyes(0.005, 0.0));
    Sight before = person.look(session_.view())->sight;
    for (int i = 0; i < kSecond - 1; ++i)
      (void)person.look(session_.view());
    Sight after = person.look(session_.view())->sight;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Place first = *before.all()[i] - *places[i];
      const Place later = *after.all()[i] - *places[i];
      for (int k = 0; k < 3; ++k)
        position.add(first[k], later[k]);
      yaw.add(first[3], later[3]);
      across.add(first[0], first[1]);
    }
  }
  EXPECT_NEAR(position.mean(), 0.0, 4.0 * 0.005 / std::sqrt(position.count));
  EXPECT_NEAR(position.sigma(), 0.005, 0.0001);
  EXPECT_NEAR(position.correlation(), std::exp(-1.0), 0.02);
  const double two_degrees = 2.0 * M_PI / 180.0;
  EXPECT_NEAR(yaw.mean(), 0.0, 4.0 * two_degrees / std::sqrt(yaw.count));
  EXPECT_NEAR(yaw.sigma(), two_degrees, 0.02 * two_degrees);
  EXPECT_NEAR(yaw.correlation(), std::exp(-1.0), 0.04);
  EXPECT_NEAR(across.correlation(), 0.0, 0.04);
}

TEST_F(EyesTest, WhatIsSeenIsExactlyAReactionTimeOld) {
  Eyes now(robot_, 0, eyes(0.0, 0.0));
  Eyes person(robot_, 0, eyes(0.0, 0.25));
  const std::size_t delay = 50;
  std::vector<Seen> history;
  for (std::size_t i = 0; i < 600; ++i) {
    session_.step(walk());
    history.push_back(*now.look(session_.view()));
    const Seen* seen = person.look(session_.view());
    ASSERT_EQ(seen != nullptr, i >= delay);
    if (seen == nullptr) continue;
    const Seen& then = history[i - delay];
    EXPECT_NEAR(session_.t() - seen->page.t, 0.25, 1e-9);
    EXPECT_EQ(seen->page.activity, then.page.activity);
    EXPECT_EQ(seen->sight.trunk, then.sight.trunk);
    EXPECT_EQ(seen->sight.sole.left, then.sight.sole.left);
  }
  EXPECT_NE(history.front().sight.trunk, history.back().sight.trunk);
}

TEST_F(EyesTest, ASteadyWalkIsForeseen) {
  Eyes person(robot_, 0, eyes(0.0, 0.25));
  Eyes now(robot_, 0, eyes(0.0, 0.0));
  for (int i = 0; i < 5 * kSecond; ++i) {
    session_.step(walk());
    (void)person.look(session_.view());
    (void)now.look(session_.view());
  }
  const Place truth = now.foresee(0.0).trunk;
  EXPECT_NEAR(person.foresee(0.25).trunk.x(), truth.x(), 0.005);
}

TEST_F(EyesTest, SameSeedSameSight) {
  Eyes one(robot_, 3, eyes(0.005, 0.0));
  Eyes two(robot_, 3, eyes(0.005, 0.0));
  Eyes third(robot_, 4, eyes(0.005, 0.0));
  session_.step(Command{});
  const Place seen = one.look(session_.view())->sight.hand;
  EXPECT_EQ(seen, two.look(session_.view())->sight.hand);
  EXPECT_NE(seen, third.look(session_.view())->sight.hand);
}

TEST_F(EyesTest, TheMeanOfALookErrsAsMuchAsItSaysAlsoAfterAMove) {
  const Eyes::Parameters parameters = eyes(0.005, 0.0);
  const Vec3 by(0.02, -0.01, 0.03);
  session_.step(Command{});
  Eyes exact(robot_, 0, eyes(0.0, 0.0));
  const Vec3 hand = exact.look(session_.view())->sight.hand.head<3>();
  Moments looked;
  Moments moved;
  double doubt = 0.0;
  double doubt_after = 0.0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Eyes person(robot_, seed, parameters);
    Mean mean(parameters);
    EXPECT_TRUE(std::isinf(mean.doubt()));
    double t = 0.0;
    const auto look = [&](double seconds, const Vec3& shift) {
      for (int i = 0; i < seconds * kSecond; ++i, t += 1.0 / kSecond) {
        Place seen = person.look(session_.view())->sight.hand;
        seen.head<3>() += shift;
        mean.see(t, seen);
      }
    };
    look(2.0, Vec3::Zero());
    doubt = mean.doubt();
    for (int k = 0; k < 3; ++k)
      looked.add(mean.place()[k] - hand[k], 0.0);
    mean.moved(by, 0.0);
    look(2.0, by);
    doubt_after = mean.doubt();
    for (int k = 0; k < 3; ++k)
      moved.add(mean.place()[k] - hand[k] - by[k], 0.0);
  }
  EXPECT_NEAR(doubt, 0.005 / std::sqrt(2.0), 1e-5);  // sigma / sqrt(1 + T / 2 tau)
  EXPECT_NEAR(looked.sigma(), doubt, 0.05 * doubt);
  EXPECT_NEAR(doubt_after, 0.005 / std::sqrt(3.0), 1e-5);
  EXPECT_NEAR(moved.sigma(), doubt_after, 0.05 * doubt_after);
}

TEST(Mean, AMoveOfUnknownSizeLeavesLittleOfWhatWasKnown) {
  const Eyes::Parameters parameters;
  Mean mean(parameters);
  mean.see(0.0, Place::Zero());
  EXPECT_DOUBLE_EQ(mean.doubt(), parameters.error);
  mean.moved(Vec3(0.1, 0.0, 0.0), 0.012);
  EXPECT_NEAR(mean.doubt(), 0.013, 1e-9);
  EXPECT_DOUBLE_EQ(mean.place().x(), 0.1);
  mean.forget();
  EXPECT_TRUE(std::isinf(mean.doubt()));
}

}  // namespace
}  // namespace baton
