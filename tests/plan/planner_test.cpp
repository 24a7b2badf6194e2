#include "baton/plan/planner.hpp"

#include <gtest/gtest.h>

#include "baton/guide/guide.hpp"
#include "baton/ik/stand.hpp"
#include "tests/support/robots.hpp"
#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

class PlannerTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const World world_ = World::load("flat");
  const Limits limits_ = Limits::normal(robot_.profile());
  const double size_ = robot_.profile().stance.com_height / 0.26;

  /// Goals of a robot whose COM is off, in turn and at random; one in two is planned by `second`.
  /// @param most offset of the COM, forward and aside [m]
  /// @param see is shown each motion that is found, and the limits that it was planned within
  /// @returns the number of goals, and of motions
  template <typename See>
  std::pair<int, int> plan_with_com_off(std::uint64_t seed, double most, DurationRule second, Limits limits, See see) {
    Planner planner(robot_, world_);
    const Guide guide(robot_, world_);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::pair<int, int> count{0, 0};
    for (std::size_t k = 0; k < 60; ++k) {
      GuideContext context = test::at_home(robot_);
      context.com_offset = most * Vec2(unit(random), unit(random));
      limits.com_offset = context.com_offset;
      const GuideResult guided = guide.goals(context, test::in_turn(k, random));
      const auto* goals = std::get_if<std::vector<Goal>>(&guided);
      if (goals == nullptr) continue;
      ++count.first;
      const DurationRule rule = k % 2 == 0 ? DurationRule::paper : second;
      const PlanResult result = planner.plan(context.from, goals->front(), context.anchor, limits, rule);
      const auto* found = std::get_if<PlannedMotion>(&result);
      if (found == nullptr) continue;
      ++count.second;
      see(*found->motion, limits);
    }
    return count;
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, PlannerTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

double worst(const VerifiedMotion& motion, Reason quantity) {
  for (const Margin& margin : motion.certificate().margins) {
    if (margin.quantity == quantity) return margin.value;
  }
  ADD_FAILURE() << "not verified: " << to_string(quantity);
  return 0.0;
}

TEST_P(PlannerTest, TheZmpIsPlannedForTheWholeBody) {
  // The knots are the whole body's ZMP: between the first and the last instant, where accelerations jump, what inverse
  // dynamics finds is what was planned.
  std::vector<double> errors;
  for (const VerifiedMotion& verified : test::sample_motions(GetParam())) {
    const Motion& motion = *verified;
    double error = 0.0;
    for (int k = 2; k < motion.ticks() - 1; ++k) {
      const ComState com = motion.com.at(k * motion.period);
      const MotionSample& sample = motion.samples[static_cast<std::size_t>(k)];
      error = std::max(error, (zmp_of_vrp(com.p, com.v, sample.zmp_height, motion.com.omega()) - sample.zmp).norm());
    }
    errors.push_back(error);
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.0025 * size_);
  EXPECT_LT(errors.back(), 0.008 * size_);
}

TEST_P(PlannerTest, TheZmpIsPlannedForARobotWhoseComIsOff) {
  // The ZMP of the model, displaced by the offset, stays inside the soles, and a step ends with it between the feet.
  const auto see = [&](const Motion& motion, const Limits& limits) {
    for (const MotionSample& sample : motion.samples) {
      const ConvexPolygon support = support_polygon(robot_, sample.sole, sample.contact, sample.com, sample.zmp_height);
      ASSERT_GE(support.margin(sample.zmp + limits.com_offset), robot_.profile().margin.zmp_verify - 1e-9);
    }
    if (motion.goal.kind != SegmentKind::step) return;
    const Vec2 middle = 0.5 * (motion.goal.sole.left.p + motion.goal.sole.right.p).head<2>();
    EXPECT_LT((motion.goal.com.head<2>() + limits.com_offset - middle).norm(), 1e-9);
  };
  const auto [goals, planned] = plan_with_com_off(32, 0.015 * size_, DurationRule::paper, limits_, see);
  EXPECT_GT(planned, 30);
}

TEST_P(PlannerTest, TheZmpKeepsAwayFromOuterEdges) {
  // Under either rule; and most goals still have a motion.
  Limits narrow = limits_;
  narrow.zmp_outward = 1.1 * robot_.sole_half_width();
  double nearest = 1.0;
  const auto see = [&](const Motion& motion, const Limits& limits) {
    // In the last sample the ZMP may stop where the limbs come to rest.
    for (int tick = 0; tick < motion.ticks(); ++tick) {
      const MotionSample& sample = motion.samples[static_cast<std::size_t>(tick)];
      const ComState com = motion.com.at(tick * motion.period);
      const Vec2 zmp = zmp_of_vrp(com.p, com.v, sample.zmp_height, motion.com.omega());
      for (const Side side : kSides) {
        if (!sample.contact[side]) continue;
        const Pose& sole = sample.sole[side];
        const Vec3 from_sole = sole.R.transpose() * (Vec3(zmp.x(), zmp.y(), sole.p.z()) - sole.p);
        double edge = 0.0;
        for (const Vec2& corner : robot_.sole(side).vertices())
          edge = std::max(edge, sign_of(side) * corner.y());
        const double inside = edge - sign_of(side) * from_sole.y();
        nearest = std::min(nearest, inside);
        ASSERT_GE(inside, limits.zmp_outward - 1e-3 * size_) << tick;
      }
    }
  };
  const auto [goals, planned] = plan_with_com_off(33, 0.01 * size_, DurationRule::search, narrow, see);
  EXPECT_LT(nearest, limits_.zmp_plan + robot_.sole_half_width());  // it does matter
  EXPECT_GT(planned, 3 * goals / 4);
}

TEST_P(PlannerTest, TheSearchIsSeldomLongerThanThePapersRuleAndAsWellVerified) {
  Planner paper(robot_, world_, DurationRule::paper);
  Planner search(robot_, world_, DurationRule::search);
  const Guide guide(robot_, world_);
  std::mt19937_64 random(31);
  GuideContext context = test::at_home(robot_);
  int both = 0;
  int longer = 0;
  int only_paper = 0;
  double sum_paper = 0.0;
  double sum_search = 0.0;
  for (std::size_t k = 0; k < 150; ++k) {
    const GuideResult guided = guide.goals(context, test::in_turn(k, random));
    const auto* goals = std::get_if<std::vector<Goal>>(&guided);
    if (goals == nullptr) continue;
    PlanResult a = paper.plan(context.from, goals->front(), context.anchor, limits_);
    PlanResult b = search.plan(context.from, goals->front(), context.anchor, limits_);
    const auto* slow = std::get_if<PlannedMotion>(&a);
    const auto* quick = std::get_if<PlannedMotion>(&b);
    if (quick != nullptr) {
      EXPECT_GE(worst(quick->motion, Reason::zmp), robot_.profile().margin.zmp_verify);
      EXPECT_LE(worst(quick->motion, Reason::joint_torque), robot_.profile().margin.torque);
      EXPECT_LE(quick->motion->duration(), robot_.profile().duration.max + 1e-9);
    }
    if (slow == nullptr) continue;
    only_paper += quick == nullptr ? 1 : 0;
    if (quick != nullptr) {
      ++both;
      longer += quick->motion->duration() > slow->motion->duration() + 1e-9 ? 1 : 0;
      sum_paper += slow->motion->duration();
      sum_search += quick->motion->duration();
    }
    test::go_on(context, *slow->motion);
  }
  EXPECT_GT(both, 50);
  EXPECT_LE(longer, both / 10);
  EXPECT_LE(only_paper, both / 20);
  EXPECT_LT(sum_search, 0.8 * sum_paper);
}

TEST_P(PlannerTest, ALoadIsRefusedSoonButSeldomWhereALongerDurationWouldDo) {
  // The paper's rule gives up where longer durations seem to be in vain; the search goes on to the longest.
  const Guide guide(robot_, world_);
  Planner paper(robot_, world_, DurationRule::paper);
  Planner search(robot_, world_, DurationRule::search);
  const auto expect_seldom = [&](Reason reason, std::initializer_list<double> shares, auto limit_of, int least) {
    std::mt19937_64 random(37);
    int refused = 0;
    int found = 0;
    long tried = 0;
    for (const double share : shares) {
      Limits weak = limits_;
      limit_of(weak) = share * limit_of(weak);
      GuideContext context = test::at_home(robot_);
      for (std::size_t k = 0; k < 60; ++k) {
        const GuideResult guided = guide.goals(context, test::in_turn(k, random));
        const auto* goals = std::get_if<std::vector<Goal>>(&guided);
        if (goals == nullptr) continue;
        const long before = paper.tried();
        PlanResult a = paper.plan(context.from, goals->front(), context.anchor, weak);
        if (const auto* planned = std::get_if<PlannedMotion>(&a)) {
          test::go_on(context, *planned->motion);
        } else if (std::get<Refusal>(a).reason == reason) {
          ++refused;
          tried += paper.tried() - before;
          const PlanResult b = search.plan(context.from, goals->front(), context.anchor, weak);
          found += std::holds_alternative<PlannedMotion>(b) ? 1 : 0;
        }
      }
    }
    EXPECT_GT(refused, least) << to_string(reason);
    EXPECT_LE(found, refused / 20) << to_string(reason) << ", of " << refused;
    EXPECT_LT(tried, 8 * refused) << to_string(reason) << ": of 26 durations each";
  };
  // Enough for some of it.
  expect_seldom(
      Reason::joint_torque, {0.44, 0.5, 0.56, 0.67}, [](Limits& l) -> double& { return l.torque; }, 20);
  expect_seldom(
      Reason::joint_acceleration, {0.02, 0.04, 0.06, 0.1}, [](Limits& l) -> double& { return l.acceleration; }, 10);
}

TEST_P(PlannerTest, AFootInTheAirThatLandsBesideGoesThereBeforeItSinks) {
  Planner planner(robot_, world_);
  const Guide guide(robot_, world_);
  std::mt19937_64 random(37);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int landed = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const GuideContext at_home = test::at_home(robot_);
    Command up;
    up.guide = trial % 2 == 0 ? Part::left_foot : Part::right_foot;
    const Side side = side_of(up.guide);
    up.lift[side] = 0.5;
    const GuideResult lifted = guide.goals(at_home, up);
    PlanResult lift = planner.plan(at_home.from, std::get<std::vector<Goal>>(lifted).front(), Pose{}, limits_);
    ASSERT_TRUE(std::holds_alternative<PlannedMotion>(lift));
    const Posture hanging = std::get<PlannedMotion>(lift).motion->end;
    const GuideResult landings = guide.landings({hanging, at_home.anchor, at_home.last_step, at_home.foothold}, side);
    Goal goal = std::get<std::vector<Goal>>(landings).front();
    goal.sole[side].p += size_ * Vec3(0.04 * unit(random), sign_of(side) * 0.01 * (1.0 + unit(random)), 0);
    const Vec3 way = goal.sole[side].p - hanging.sole[side].p;
    PlanResult planned = planner.plan(hanging, goal, Pose{}, limits_);
    if (way.head<2>().norm() < 0.005 * size_ || !std::holds_alternative<PlannedMotion>(planned)) continue;
    for (const MotionSample& sample : std::get<PlannedMotion>(planned).motion->samples) {
      const Vec3 gone = sample.sole[side].p - hanging.sole[side].p;
      if (gone.z() / way.z() > 0.01) {
        EXPECT_GT(gone.head<2>().norm(), 0.6 * way.head<2>().norm());
      }
    }
    ++landed;
  }
  EXPECT_GT(landed, 30);
}

TEST_P(PlannerTest, AMotionRunBackwardsHasTheSameMargins) {
  Planner planner(robot_, world_);
  Posture from = stand(robot_, Pose{}, robot_.profile().stance.com_height);
  int checked = 0;
  for (const VerifiedMotion& motion : test::sample_motions(GetParam())) {
    const Trail trail = trail_of(from, *motion);
    const PlanResult back = planner.retrace(trail, Pose{}, limits_);
    ASSERT_TRUE(std::holds_alternative<PlannedMotion>(back)) << to_string(std::get<Refusal>(back).reason);
    const VerifiedMotion& reverse = std::get<PlannedMotion>(back).motion;
    for (const Reason quantity : {Reason::zmp, Reason::joint_torque, Reason::joint_speed, Reason::friction})
      EXPECT_NEAR(worst(reverse, quantity), worst(motion, quantity), 1e-6 * (1.0 + std::abs(worst(motion, quantity))));
    EXPECT_EQ(reverse->end.q, from.q);
    EXPECT_EQ(reverse->samples.front().q, motion->end.q);
    ++checked;
    from = motion->end;
  }
  EXPECT_GT(checked, 15);
}

}  // namespace
}  // namespace baton
