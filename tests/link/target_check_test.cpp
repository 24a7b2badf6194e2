#include "baton/link/target_check.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "baton/proving/scenario.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton::link {
namespace {

using testing::HasSubstr;

class TargetCheckTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
};

INSTANTIATE_TEST_SUITE_P(Robots, TargetCheckTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

// In all that may happen to it: pushes that fell it, steps that catch it, sensors that fail.
TEST_P(TargetCheckTest, NothingThatTheNavigatorSendsIsRejected) {
  const World world = World::load("flat");
  long followed = 0;
  long falls = 0;
  const std::vector<std::pair<std::string, double>> cases{
      {"real", 2.0}, {"push", 3.0}, {"push_walk", 4.0}, {"push_fore", 2.2}, {"glitches_walk", 3.0}, {"tiles", 2.0}};
  for (const auto& disturbance : cases) {
    const std::string& name = disturbance.first;
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Scenario& scenario = scenario_named(name);
      Simulation::Parameters parameters;
      parameters.physics.plant = plant_of(true, &scenario, robot_, seed, disturbance.second);
      Simulation simulation(robot_, world, Simulation::On::sim, parameters);
      Session& session = simulation.session();
      TargetCheck check(robot_);
      bool begins = true;
      Hooks hooks;
      hooks.tick = [&](const TickRecord& record) {
        const VecX& q = record.measurement.q;  // spoiled by glitches, too
        if (std::exchange(begins, false)) check.begin(q);
        const Target target{0, record.target.q + record.target.q_correction, record.target.dq, record.target.tau};
        const std::optional<std::string> why = check.reject(target, q);
        EXPECT_EQ(why, std::nullopt) << name << ' ' << seed << " at " << record.t;
        ++followed;
      };
      session.add(hooks);
      const std::unique_ptr<Device> stick = stick_of(scenario, robot_, seed);
      while (session.t() < 8.0 && !(session.fallen() && session.navigator().guard() == Guard::fallen))
        session.step(stick->read(session.t()));
      falls += session.fallen() ? 1 : 0;
    }
  }
  EXPECT_GT(followed, 10'000);
  EXPECT_GT(falls, 0);
}

TEST_P(TargetCheckTest, AJumpIsNotFollowedFromWhereTheLastTargetAndTheJointAre) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const double period = robot_.profile().tick.period;
  int rejected = 0;
  for (int run = 0; run < 2000; ++run) {
    const auto i = static_cast<Eigen::Index>(random() % static_cast<std::uint64_t>(n_));
    const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
    VecX q(n_);
    for (Eigen::Index k = 0; k < n_; ++k) {
      const Range& range = robot_.joints()[static_cast<std::size_t>(k)].position;
      q[k] = range.lo + (range.hi - range.lo) * (0.5 + 0.5 * share(random));
    }
    TargetCheck check(robot_);
    check.begin(q);
    Target target{0, q, VecX::Zero(n_), VecX::Zero(n_)};
    const double jump = share(random);
    target.q[i] = std::clamp(q[i] + jump, joint.position.lo, joint.position.hi);
    const double step = std::abs(target.q[i] - q[i]);
    const double explained = joint.motor.no_load * period;
    const std::optional<std::string> why = check.reject(target, q);
    if (step > 3.0 * explained + 0.04) {
      ASSERT_TRUE(why.has_value()) << joint.name << ' ' << step;
      EXPECT_THAT(*why, HasSubstr(joint.name));
      // Still what counts is the last one that was followed.
      target.q = q;
      EXPECT_EQ(check.reject(target, q), std::nullopt);
      ++rejected;
    } else if (step < explained) {
      EXPECT_EQ(why, std::nullopt);
    }
  }
  EXPECT_GT(rejected, 200);
}

TEST_P(TargetCheckTest, WhatNoMotorCanDoIsNotFollowed) {
  const VecX q = VecX::Zero(n_);
  VecX home(n_);
  for (Eigen::Index k = 0; k < n_; ++k) {
    const Range& range = robot_.joints()[static_cast<std::size_t>(k)].position;
    home[k] = std::clamp(0.0, range.lo, range.hi);
  }
  TargetCheck check(robot_);
  check.begin(home);
  for (Eigen::Index i = 0; i < n_; ++i) {
    const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
    const Target still{0, home, VecX::Zero(n_), VecX::Zero(n_)};
    EXPECT_EQ(check.reject(still, home), std::nullopt);
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
      for (VecX Target::*const part : {&Target::q, &Target::dq, &Target::tau}) {
        Target target = still;
        (target.*part)[i] = bad;
        const std::optional<std::string> why = check.reject(target, home);
        ASSERT_TRUE(why.has_value()) << joint.name;
        EXPECT_THAT(*why, HasSubstr(joint.name));
        EXPECT_THAT(*why, HasSubstr("must be"));
      }
    }
  }
}

}  // namespace
}  // namespace baton::link
