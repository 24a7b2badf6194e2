/// Every reason for a refusal, met on the way from a command to a motion.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <random>

#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"
#include "tests/guide/commands.hpp"
#include "tests/support/temp.hpp"
#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

using test::push;

const std::string kFloor = R"(<geom name="ground" type="plane" size="0 0 0.05"/>)";

/// A robot, a world and a request that is refused.
struct Case {
  Profile profile;
  std::string geoms = kFloor;
  Command command;
  std::function<void(Request&)> change = [](Request&) {};
};

/// A box that may be stood on, from `x` on forward or, if that is negative, backward; its top at `z`.
std::string ground_box(const std::string& name, double x, double forward, double z) {
  return fmt::format(R"(<geom name="{}" type="box" pos="{} 0 {}" size="9 9 1"/>)", name, x + 9.0 * forward, z - 1.0);
}

class RefusalsTest : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] Answer plan(const Case& c) const {
    const RobotModel robot(c.profile);
    const std::string file = test::temp_folder() + "refusals.xml";
    std::ofstream(file) << "<mujoco><worldbody><site name=\"start\"/>" << c.geoms << "</worldbody></mujoco>";
    const World world{file};
    Strategy strategy(robot, world, {DurationRule::paper, OnLimit::discard});
    Request request;
    request.command = c.command;
    request.intents = {intent_of(c.command)};
    request.start.context = test::at_home(robot);
    c.change(request);
    request.start.posture = request.start.context.from;
    return strategy.plan(request);
  }

  [[nodiscard]] Posture with_an_arm_in_the_trunk(VecX q) const {
    Kinematics kinematics(robot_);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(0.1, 0.9);
    const VecX before = q;
    do {
      q = before;
      for (const int j : robot_.arm(Side::left)) {
        const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
        q[7 + j] = range.lo + share(random) * (range.hi - range.lo);
      }
      kinematics.set(q);
    } while (kinematics.self_distance(1.0) > -1e-3);
    return posture_of(robot_, q);
  }

  /// What is refused for that reason; nothing is asked for if that is not known.
  [[nodiscard]] Case refused_for(Reason reason) const {
    const Command step = push(Part::left_foot, 0);
    const Posture home = test::at_home(robot_).from;
    double toe = 0.0;
    for (const Vec2& vertex : robot_.sole(Side::left).vertices())
      toe = std::max(toe, vertex.x());
    toe += home.sole.left.p.x();
    const double edge = robot_.profile().margin.edge;
    const double size = robot_.profile().stance.com_height;

    Case c;
    c.profile = robot_.profile();
    Profile& p = c.profile;
    switch (reason) {
      case Reason::foot_region:
        c.command = push(Part::left_foot, 1, -1.0);  // onto the other foot
        break;
      case Reason::foot_yaw:
        p.region.foot_yaw = 0.5 * p.reach.rotation;
        c.command = push(Part::left_foot, 5);
        break;
      case Reason::sole_gap:
        p.region.sole_gap = p.stance.width;
        c.command = step;
        break;
      case Reason::ground:
        c.geoms = ground_box("ground", toe + 1.01 * edge, -1.0, 0.0);
        c.command = step;
        break;
      case Reason::com_height:
        p.region.com_height.hi = p.stance.com_height;
        c.command = push(Part::trunk, 2);
        break;
      case Reason::trunk_inclination:
        p.region.trunk_inclination = 0.5 * p.reach.rotation;
        c.command = push(Part::trunk, 4);
        break;
      case Reason::no_progress:
        c.geoms = ground_box("ground", toe + 1.01 * edge, -1.0, 0.0);
        c.command = push(Part::trunk, 0);
        break;
      case Reason::no_landing:
        p.phases.lower = {0.99, 0.01};  // the COM cannot come between the feet that quickly
        c.command.guide = Part::left_foot;
        c.command.lift.left = 1.0;
        break;
      case Reason::no_history:
        c.command.recall = Recall::retrace;
        break;
      case Reason::inclined_sole:
        c.command = step;
        c.change = [](Request& request) { request.terrain.inclined = {Side::right, 0.15}; };
        break;
      case Reason::zmp:
        p.margin.zmp_plan = p.stance.width;
        c.command = step;
        break;
      case Reason::unreachable:
        p.ik.hand = 1e-9;  // no hand comes as near to its goal as that
        c.command = push(Part::left_hand, 2, 0.2);
        break;
      case Reason::joint_limit:
        p.region.com_height.lo = 0.5 * size;
        p.reach.trunk = 0.5 * size;
        c.command = push(Part::trunk, 2, -1.0);
        break;
      case Reason::joint_speed:
        p.margin.speed = 0.01;
        c.command = step;
        break;
      case Reason::joint_acceleration:
        p.margin.acceleration = 0.1;
        c.command = step;
        break;
      case Reason::joint_torque:
        p.margin.torque = 0.3;  // less than a knee needs, but enough for the ankles
        c.command = step;
        break;
      case Reason::motor_heat:
        for (const Joint& joint : robot_.joints())
          p.heat[joint.name].continuous = 0.02;  // hot before the foot is down
        c.command = step;
        break;
      case Reason::friction:
        p.margin.friction = 1e-3;
        p.duration.max = p.duration.first;
        c.command = push(Part::trunk, 0, 0.3);
        break;
      case Reason::contact_wrench: {
        // Hardly less slippery than the tangential force as a whole: the soles' vertices cannot give the moment, too.
        c.command = step;
        const Answer planned = plan(c);
        const VerifiedMotion& motion = std::get<PlannedMotion>(planned.outcome).motion;
        p.duration.first = p.duration.max = motion->duration();
        for (const Margin& margin : motion.certificate().margins) {
          if (margin.quantity == Reason::friction) p.margin.friction = 1.05 * margin.value;
        }
        break;
      }
      case Reason::self_collision:
        c.command = push(Part::left_foot, 0, 0.3);
        c.change = [this](Request& request) {
          request.start.context.from = with_an_arm_in_the_trunk(request.start.context.from.q);
        };
        break;
      case Reason::obstacle:
        c.geoms += fmt::format(R"(<geom name="crate" type="sphere" size="{}" pos="{} {} {}"/>)", 0.02 * size,
                               home.hand.left.p.x(), home.hand.left.p.y(), home.hand.left.p.z());
        c.command = push(Part::trunk, 0, 0.3);
        break;
      case Reason::swing_ground:
        c.geoms += ground_box("ground_step", toe + 1.5 * edge, 1.0, 0.1 * size);  // the toe would go through it
        c.command = push(Part::left_foot, 0);
        c.command.lift.left = 0.2;
        break;
      case Reason::not_finite:
        c.command = push(Part::left_hand, 0);
        c.change = [](Request& request) { request.start.context.from.hand.left.p.x() = std::nan(""); };
        break;
    }
    return c;
  }

  const RobotModel& robot_ = test::robot(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Robots, RefusalsTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(RefusalsTest, AFootThatASlipBroughtNearerToAStepThanTheMarginCanLeave) {
  double heel = 0.0;
  for (const Vec2& vertex : robot_.sole(Side::left).vertices())
    heel = std::max(heel, -vertex.x());
  heel -= test::at_home(robot_).from.sole.left.p.x();
  const double edge = robot_.profile().margin.edge;
  for (const double away : {1.5, 0.6, 0.1}) {
    Case c;
    c.profile = robot_.profile();
    const double riser = 0.1 * c.profile.stance.com_height;
    c.geoms = kFloor + ground_box("ground_step", -heel - away * edge, -1.0, riser);
    for (const Command& command : {push(Part::left_foot, 0), push(Part::trunk, 0)}) {
      c.command = command;
      const Answer result = plan(c);
      EXPECT_TRUE(std::holds_alternative<PlannedMotion>(result.outcome)) << away;
    }
  }
}

TEST_P(RefusalsTest, ARestThatCannotBeHeldForEverNeedsAWayToOneThatCan) {
  Case c;
  c.profile = robot_.profile();
  c.command = push(Part::trunk, 2, -1.0);
  const Answer cool = plan(c);
  ASSERT_NE(cool.motion(), nullptr);
  const Hottest held = cool.motion()->held;
  ASSERT_GT(held.total, 0.0);
  // Motors that can just not hold the squat, though the way there is cool.
  for (const Joint& joint : robot_.joints()) {
    Thermal& motor = c.profile.heat[joint.name];
    motor.continuous *= 0.99 * std::sqrt(held.total);
    motor.winding_time = motor.housing_time = 1e4;
  }
  EXPECT_NE(plan(c).motion(), nullptr) << "it can rise again";
  // One that may not stand higher than that has no such way.
  c.profile.region.com_height.hi = 1.0005 * c.profile.region.com_height.lo;
  const Answer warm = plan(c);
  ASSERT_NE(warm.refusal(), nullptr);
  EXPECT_EQ(warm.refusal()->reason, Reason::motor_heat);
  EXPECT_EQ(warm.refusal()->where, robot_.joints()[static_cast<std::size_t>(held.joint)].name);
  EXPECT_NEAR(warm.refusal()->value, 1.0 / (0.99 * 0.99), 1e-6);
}

TEST_P(RefusalsTest, AHotRobotHasAWayToCoolWhereverItWasLetGo) {
  Case c;
  c.profile = robot_.profile();
  for (const Joint& joint : robot_.joints())
    c.profile.heat[joint.name].continuous *= 0.8;
  const RobotModel weak(c.profile);
  const double h = weak.profile().stance.com_height;
  const std::string file = test::temp_folder() + "by_a_wall.xml";
  std::ofstream(file) << "<mujoco><worldbody><site name=\"start\"/>" << kFloor
                      << fmt::format(R"(<geom name="wall" type="box" pos="{} 0 {}" size="{} 9 {}"/>)", 0.75 * h,
                                     2.0 * h, 0.1 * h, 1.5 * h)
                      << "</worldbody></mujoco>";
  const World world{file};
  Strategy strategy(weak, world, {DurationRule::paper, OnLimit::discard});
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int hot = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Request request;
    request.start.context = test::at_home(weak);
    request.start.context.com_offset = 0.12 * h * Vec2(unit(random), unit(random));
    request.start.context.place_uncertainty = 0.2 * h * std::abs(unit(random));
    for (int leg = 0; leg < 3; ++leg) {  // of the way
      request.start.posture = request.start.context.from;
      request.command = test::random_command(random);
      if (leg == 0) request.command = push(Part::trunk, 0, 1.0);
      request.intents = {intent_of(request.command)};
      const Answer answer = strategy.plan(request);
      if (answer.motion() == nullptr) continue;
      test::go_on(request.start.context, *answer.motion());
      if (answer.motion()->held.total <= 1.0 || !answer.motion()->end.contact.left ||
          !answer.motion()->end.contact.right)
        continue;
      ++hot;
      Request cooling = request;
      cooling.start.posture = cooling.start.context.from;
      cooling.start.posture.heat = at_least(cooling.start.posture.heat, kHot);
      cooling.intents = {Cool{}};
      EXPECT_NE(strategy.plan(cooling).motion(), nullptr) << trial << " " << leg;
    }
  }
  EXPECT_GT(hot, 15);
}

TEST_P(RefusalsTest, EveryReasonIsMetOnTheWayFromACommandToAMotion) {
  for (std::size_t i = 0; i < kReasons; ++i) {
    const auto reason = static_cast<Reason>(i);
    const Answer result = plan(refused_for(reason));
    const auto* refusal = std::get_if<Refusal>(&result.outcome);
    ASSERT_NE(refusal, nullptr) << to_string(reason) << ": nothing is refused";
    EXPECT_EQ(refusal->reason, reason) << to_string(reason) << " is " << to_string(refusal->reason) << " "
                                       << refusal->value << " " << refusal->limit << " " << place(*refusal);
    // What its numbers mean is what the table says, of the reason or of the one behind it.
    const bool has_cause = reason == Reason::no_progress || reason == Reason::no_landing;
    ASSERT_EQ(refusal->cause.has_value(), has_cause) << to_string(reason);
    const ReasonInfo& numbers = info(refusal->cause.value_or(reason));
    if (numbers.reason == Reason::ground) {
      EXPECT_TRUE(refusal->value >= 0.0) << "less than its limit where an edge is too near";
    } else if (numbers.bound == Bound::at_most) {
      EXPECT_GE(refusal->value, refusal->limit) << numbers.name;
    } else if (numbers.bound == Bound::at_least) {
      EXPECT_LE(refusal->value, refusal->limit) << numbers.name;
    } else if (numbers.bound == Bound::range) {
      EXPECT_NE(refusal->value, refusal->limit) << numbers.name;
    } else {
      EXPECT_TRUE(refusal->value == 0.0 && refusal->limit == 0.0) << numbers.name;
    }
  }
}

// As after a capture step: G1 once stayed where it was for good, as its ankle behind kept the COM from the foot ahead.
TEST_P(RefusalsTest, ATrunkIsLedOutOfTheLongestStance) {
  Profile profile = robot_.profile();
  profile.region.stride *= 0.5;  // its own steps are shorter than those of a guided foot
  profile.margin.joint = 0.15;
  const double h = profile.stance.com_height;
  const RobotModel robot(profile);
  const World world = World::load("flat");
  Strategy shrinks(robot, world, {DurationRule::paper, OnLimit::shrink});
  Strategy discards(robot, world, {DurationRule::paper, OnLimit::discard});
  const auto ahead = [](const BySide<Pose>& sole) {
    return (rotation_z(-mean_yaw(sole)) * (sole.left.p - sole.right.p)).x();
  };
  int closed = 0;
  for (const Side side : kSides) {
    for (const double way : {1.0, -1.0}) {
      for (const double height : {0.0, 1.0}) {  // the higher, the less do the legs reach
        Request request;
        request.start.context = test::at_home(robot);
        const auto go = [&](Strategy& strategy, const Command& command) {
          request.start.posture = request.start.context.from;
          request.command = command;
          request.intents = {intent_of(command)};
          Answer answer = strategy.plan(request);
          if (answer.motion() != nullptr) test::go_on(request.start.context, *answer.motion());
          return answer;
        };
        for (const double share : {1.0, 1.0, 0.5, 0.5, 0.25, 0.25})
          go(discards, push(foot(side), 0, way * share));
        for (int k = 0; k < 3; ++k)
          go(shrinks, push(Part::trunk, 2, height));
        const double stance = std::abs(ahead(request.start.context.from.sole));
        ASSERT_GT(stance, profile.region.stride + 0.02 * h);
        for (int k = 0; k < 10; ++k) {
          const Answer answer = go(shrinks, push(Part::trunk, 0, way));
          ASSERT_NE(answer.motion(), nullptr) << to_string(answer.refusal()->reason) << " " << answer.refusal()->where;
          const Goal& goal = answer.motion()->goal;
          closed += goal.swing && std::abs(ahead(goal.sole)) < 1e-3 * h ? 1 : 0;
        }
        const Posture& end = request.start.context.from;
        EXPECT_GT(way * (end.com - test::at_home(robot).from.com).x(), profile.region.stride);
      }
    }
  }
  EXPECT_GT(closed, 0);
}

}  // namespace
}  // namespace baton
