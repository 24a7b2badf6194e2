#include "baton/guide/guide.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "baton/ik/stand.hpp"
#include "baton/model/contact.hpp"
#include "tests/guide/commands.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::push;

const World& flat() {
  static const World world = World::load("flat");
  return world;
}

const World& room() {
  static const World world = World::load("room");
  return world;
}

class GuideTest : public testing::TestWithParam<std::string> {
 protected:
  GuideTest() : home_(stand(robot_, Pose{}, robot_.profile().stance.com_height)) {}

  [[nodiscard]] GuideContext context(const Posture& from) const { return {from, Pose{}, Side::right, from.sole}; }
  [[nodiscard]] GuideContext at_home() const { return context(home_); }

  static const Goal& first(const GuideResult& result) { return std::get<std::vector<Goal>>(result).front(); }
  static bool refused_for(const GuideResult& result, Reason reason) {
    const auto* refusal = std::get_if<Refusal>(&result);
    return refusal != nullptr && refusal->reason == reason;
  }

  /// A stance with the feet anywhere in their region.
  Posture random_stance(std::mt19937_64& random) const {
    const Profile::Region& region = robot_.profile().region;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    Posture posture = home_;
    const Pose& left = posture.sole.left;
    posture.sole.right =
        left *
        Pose{
            Vec3((2 * unit(random) - 1) * region.stride,
                 -(region.foot_lateral.lo + unit(random) * 0.5 * (region.foot_lateral.hi - region.foot_lateral.lo)), 0),
            rotation_z((2 * unit(random) - 1) * 0.1)};
    const double height = region.com_height.lo + unit(random) * (region.com_height.hi - region.com_height.lo);
    posture.com = 0.5 * (posture.sole.left.p + posture.sole.right.p) + Vec3(0, 0, height);
    // Upright, or leaning: as far as it may, or farther, as after a slip or on its way.
    const double lean = 1.5 * region.trunk_inclination * std::max(0.0, 2 * unit(random) - 1);
    posture.trunk = rotation_exp(rotation_z(6.0 * unit(random)) * Vec3(lean, 0, 0)) * posture.trunk;
    return posture;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  Posture home_;
};

INSTANTIATE_TEST_SUITE_P(Robots, GuideTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(GuideTest, NothingIsAskedForByACentredStick) {
  const Guide guide(robot_, flat());
  for (const Part part : kParts) {
    EXPECT_TRUE(std::holds_alternative<std::monostate>(guide.goals(at_home(), push(part, 0, 0.0))));
  }
  Command broken;
  broken.axes.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(std::holds_alternative<std::monostate>(guide.goals(at_home(), broken)));
  // Only the guided foot's throttle counts.
  Command other_throttle = push(Part::left_foot, 0, 0.0);
  other_throttle.lift.right = 1.0;
  EXPECT_TRUE(std::holds_alternative<std::monostate>(guide.goals(at_home(), other_throttle)));
}

TEST_P(GuideTest, EveryGoalIsConsistent) {
  const Guide guide(robot_, flat());
  const Profile::Region& region = robot_.profile().region;
  std::mt19937_64 random(11);
  int goals = 0;
  int refusals = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Posture from = random_stance(random);
    const Command command = test::random_command(random);
    const GuideResult result = guide.goals(context(from), command);
    if (std::holds_alternative<Refusal>(result)) ++refusals;
    const auto* list = std::get_if<std::vector<Goal>>(&result);
    if (list == nullptr) continue;
    ASSERT_FALSE(list->empty());
    for (const Goal& goal : *list) {
      ++goals;
      ASSERT_TRUE(goal.com.allFinite() && goal.trunk.allFinite() && goal.arms.allFinite());
      ASSERT_TRUE(goal.contact.left || goal.contact.right) << "at least one foot stands";
      if (goal.swing) {
        const Side stance = other(*goal.swing);
        ASSERT_EQ(goal.sole[stance].p, from.sole[stance].p) << "the stance foot keeps its place";
        const Vec3 relative =
            rotation_z(-yaw_of(from.sole[stance].R)) * (goal.sole[*goal.swing].p - from.sole[stance].p);
        EXPECT_LE(std::abs(relative.x()), region.foot_x.hi + 1e-6);
        EXPECT_GE(sign_of(*goal.swing) * relative.y(), region.foot_lateral.lo - 1e-6);
        EXPECT_LE(sign_of(*goal.swing) * relative.y(), region.foot_lateral.hi + 1e-6);
        EXPECT_GE(separation(sole_outline(robot_, Side::left, goal.sole.left),
                             sole_outline(robot_, Side::right, goal.sole.right)),
                  region.sole_gap);
        // Above the stance foot while the other is up, above their middle when both stand.
        const Vec2 below = goal.contact[*goal.swing] ? Vec2(0.5 * (goal.sole.left.p + goal.sole.right.p).head<2>())
                                                     : Vec2(from.sole[stance].p.head<2>());
        EXPECT_LT((goal.com.head<2>() - below).norm(), 1e-9);
      } else {
        EXPECT_EQ(goal.sole.left.p, from.sole.left.p);
        EXPECT_EQ(goal.sole.right.p, from.sole.right.p);
        const ConvexPolygon support = support_polygon(robot_, goal.sole, goal.contact, goal.com, 0.0);
        EXPECT_GE(support.margin(goal.com.head<2>()),
                  std::min(robot_.profile().margin.stand_on, support.margin(from.com.head<2>())) - 1e-9);
      }
      Posture end;
      end.sole = goal.sole;
      end.contact = goal.contact;
      const double height = goal.com.z() - end.support_height();
      EXPECT_GE(height, region.com_height.lo - 1e-9);
      EXPECT_LE(height, region.com_height.hi + 1e-9);
      EXPECT_LE(tilt_of(goal.trunk), region.trunk_inclination + 1e-9);
    }
  }
  EXPECT_GT(goals, 1500);
  EXPECT_GT(refusals, 100);
}

TEST_P(GuideTest, TurningTheWholeSceneTurnsTheGoals) {
  const Guide guide(robot_, flat());
  std::mt19937_64 random(12);
  int compared = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Posture from = random_stance(random);
    const Command command = test::random_command(random);
    const Pose turn{Vec3(0.3, -0.2, 0), rotation_z(std::uniform_real_distribution<double>(-3, 3)(random))};
    Posture turned = from;
    turned.com = turn * from.com;
    turned.trunk = turn.R * from.trunk;
    for (const Side side : kSides) {
      turned.sole[side] = turn * from.sole[side];
      turned.hand[side] = turn * from.hand[side];
      turned.shoulder[side] = turn * from.shoulder[side];
    }
    const GuideResult a = guide.goals(context(from), command);
    const GuideResult b = guide.goals(context(turned), command);
    ASSERT_EQ(a.index(), b.index());
    if (!std::holds_alternative<std::vector<Goal>>(a)) continue;
    ++compared;
    EXPECT_LT((turn * first(a).com - first(b).com).norm(), 1e-6);
    EXPECT_LT((turn * first(a).sole.left.p - first(b).sole.left.p).norm(), 1e-6);
    EXPECT_LT(rotation_error(turn.R * first(a).trunk, first(b).trunk).norm(), 1e-6);
  }
  EXPECT_GT(compared, 300);
}

TEST_P(GuideTest, AFootStepsOrLiftsByItsThrottle) {
  const Guide guide(robot_, flat());
  const Profile& profile = robot_.profile();
  Command command = push(Part::left_foot, 0);
  Goal goal = first(guide.goals(at_home(), command));
  EXPECT_EQ(goal.kind, SegmentKind::step);
  EXPECT_NEAR(goal.sole.left.p.x() - home_.sole.left.p.x(), profile.reach.foot, 1e-9);
  command.lift.left = 0.5;
  goal = first(guide.goals(at_home(), command));
  EXPECT_EQ(goal.kind, SegmentKind::lift);
  EXPECT_NEAR(goal.sole.left.p.z(), 0.5 * profile.swing.lift, 1e-9);
  EXPECT_FALSE(goal.contact.left);
  command = push(Part::left_foot, 1, -1.0);  // towards the other foot
  EXPECT_TRUE(refused_for(guide.goals(at_home(), command), Reason::foot_region));
}

TEST_P(GuideTest, AFootIsBroughtIntoItsRegion) {
  const Guide guide(robot_, flat());
  const Profile::Region& region = robot_.profile().region;
  std::mt19937_64 random(29);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int inside = 0;
  int brought = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const GuideContext context = this->context(random_stance(random));
    const Side side = trial % 2 == 0 ? Side::left : Side::right;
    Command command = push(foot(side), 0, unit(random));
    command.axes[1] = unit(random);
    command.axes[5] = 0.2 * unit(random);
    const Target target = *guide.target(context, command);
    const Target within = guide.within_region(context, target);
    EXPECT_EQ(within.move[5], target.move[5]);
    if (!refused_for(guide.goals(context, target), Reason::foot_region)) {
      EXPECT_TRUE(within.move.isApprox(target.move, 1e-9));
      ++inside;
      continue;
    }
    const GuideResult result = guide.goals(context, within);
    EXPECT_FALSE(refused_for(result, Reason::foot_region));
    const auto* goals = std::get_if<std::vector<Goal>>(&result);
    if (goals == nullptr) continue;
    // On the border of the region, as near to what was asked for as it goes.
    const Pose relative = context.from.sole[other(side)].inverse() * goals->front().sole[side];
    const double outward = sign_of(side) * relative.p.y();
    const double off =
        std::min({std::abs(relative.p.x() - region.foot_x.lo), std::abs(relative.p.x() - region.foot_x.hi),
                  std::abs(outward - region.foot_lateral.lo), std::abs(outward - region.foot_lateral.hi)});
    EXPECT_LT(off, 1e-9);
    ++brought;
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(brought, 100);
}

TEST_P(GuideTest, PartsOfATargetLieOnTheWayToIt) {
  const Guide guide(robot_, flat());
  const Profile& profile = robot_.profile();
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::array<int, kParts.size()> seen{};
  for (int trial = 0; trial < 3000; ++trial) {
    GuideContext context = this->context(random_stance(random));
    Command command = test::random_command(random);
    if (is_foot(command.guide) && random() % 2 == 0) {
      context.from.contact[side_of(command.guide)] = false;
      context.from.sole[side_of(command.guide)].p.z() += unit(random) * profile.swing.lift;
    }
    const std::optional<Target> whole = guide.target(context, command);
    if (!whole) continue;
    ++seen.at(static_cast<std::size_t>(whole->part));
    ASSERT_EQ(whole->part, command.guide);
    const double share = 0.05 + 0.9 * unit(random);
    const Target part = guide.part_of(context, *whole, share);
    EXPECT_LT((part.move - share * whole->move).norm(), 1e-12);
    EXPECT_EQ(part.lift > 0.0, whole->lift > 0.0) << "a foot that is to land does not stay in the air, nor the reverse";
    if (whole->lift > 0.0) {
      const double now = context.from.sole[side_of(command.guide)].p.z();
      EXPECT_NEAR(part.lift, std::max(now + share * (whole->lift - now), 0.25 * profile.swing.clearance), 1e-9);
    }
    Vec6 sum = Vec6::Zero();
    double last = std::numeric_limits<double>::infinity();
    for (const Target& single : guide.single_axes(*whole)) {
      EXPECT_EQ((single.move.array() != 0.0).count(), 1);
      EXPECT_EQ(single.lift, whole->lift);
      const double deflection = single.move.head<3>().norm() / (is_foot(single.part)   ? profile.reach.foot
                                                                : is_hand(single.part) ? profile.reach.hand
                                                                                       : profile.reach.trunk) +
                                single.move.tail<3>().norm() / profile.reach.rotation;
      EXPECT_LE(deflection, last + 1e-12) << "the largest first";
      last = deflection;
      sum += single.move;
    }
    EXPECT_LT((sum - whole->move).norm(), 1e-6);
  }
  for (const int count : seen)
    EXPECT_GT(count, 100);
}

TEST_P(GuideTest, APushStraightAheadIsCaughtByTheFootThatDidNotStepLast) {
  const Guide guide(robot_, flat());
  const double size = robot_.profile().stance.com_height;
  for (const double ahead : {-0.3, 0.3}) {
    for (const Side last : kSides) {
      GuideContext context = at_home();
      context.last_step = last;
      context.from.com.head<2>() = 0.5 * (context.from.sole.left.p + context.from.sole.right.p).head<2>();
      EXPECT_EQ(*first(guide.capture_steps(context, {ahead * size, 0.0})).swing, other(last));
      context.from.com.y() += 0.02 * size;  // the right foot carries less
      EXPECT_EQ(*first(guide.capture_steps(context, {ahead * size, 0.0})).swing, Side::right);
    }
  }
}

TEST_P(GuideTest, AStepCatchesTheRobotWhereOneCan) {
  const Guide guide(robot_, flat());
  const double size = robot_.profile().stance.com_height;
  std::mt19937_64 random(43);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int stood = 0;
  int flew = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    GuideContext context = this->context(random_stance(random));
    const Vec2 by = 0.3 * size * Vec2(unit(random), unit(random));
    const Vec3 ahead = rotation_z(-context.from.heading()) * Vec3(by.x(), by.y(), 0);
    const bool sideways = std::abs(ahead.y()) > 0.5 * std::abs(ahead.x());
    const Side up = trial % 2 == 0 ? Side::left : Side::right;
    const bool flies = trial % 3 == 0;
    if (flies) {
      context.from.contact[up] = false;
      if (trial % 9 < 6) context.step = {up, context.from.sole[up]};  // or it is held up there
      context.from.sole[up].p += Vec3(0, 0, 0.02 * size);
    }
    const bool falls = trial % 4 == 0;
    const GuideResult result = guide.capture_steps(context, by, falls);
    ASSERT_FALSE(std::holds_alternative<Refusal>(result));
    const auto* goals = std::get_if<std::vector<Goal>>(&result);
    EXPECT_EQ(goals != nullptr, flies || !sideways || falls) << "aside only where it falls otherwise";
    if (goals == nullptr) continue;
    for (const Goal& goal : *goals) {
      ASSERT_TRUE(goal.swing && goal.contact.left && goal.contact.right);
      const Side side = *goal.swing;
      EXPECT_EQ(goal.kind, flies ? SegmentKind::lower : SegmentKind::step);
      EXPECT_EQ(goal.sole[other(side)].p, context.from.sole[other(side)].p);
      const Pose relative = context.from.sole[other(side)].inverse() * goal.sole[side];
      EXPECT_GE(relative.p.x(), robot_.profile().region.foot_x.lo - 1e-9);
      EXPECT_LE(relative.p.x(), robot_.profile().region.foot_x.hi + 1e-9);
      if (flies) {
        EXPECT_EQ(side, up);
        ++flew;
      } else {
        // It does not lift the foot to whose side it is pushed.
        const bool straight = std::abs(ahead.y()) < 0.1 * std::abs(ahead.x());
        EXPECT_TRUE(straight || sign_of(side) * ahead.y() < 0.0);
        // One that is about to leave the ground is the one that can.
        GuideContext leaving = context;
        leaving.from.lift_off = LiftOff{up, 0.1};
        const GuideResult left = guide.capture_steps(leaving, by);
        const auto* ways = std::get_if<std::vector<Goal>>(&left);
        ASSERT_TRUE(ways == nullptr || ways->front().swing == up);
        ++stood;
      }
    }
    const Side side = *goals->front().swing;
    const Goal& second = (*goals)[std::min<std::size_t>(1, goals->size() - 1)];
    if (second.swing != side) continue;
    const Vec3 way = goals->front().sole[side].p - second.sole[side].p;
    EXPECT_GE(way.head<2>().dot(by), -0.01 * by.norm()) << "the first goes farther, to a grid of 1 cm";
  }
  EXPECT_GT(stood, 300);
  EXPECT_GT(flew, 300);
}

constexpr double kLeft = 0.008;  // what a step may leave of a displacement, for the next ones [COM height]

TEST_P(GuideTest, AGuidedTrunkMakesUpForSolesThatSlid) {
  const Guide guide(robot_, flat());
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int led = 0;
  int turned = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const GuideContext context = this->context(random_stance(random));
    GuideContext astray = context;
    astray.drift_correction.R = rotation_z(0.01 * unit(random));
    astray.drift_correction.p = 0.05 * robot_.profile().reach.trunk * Vec3(unit(random), unit(random), 0);
    Command command;
    command.axes << unit(random), unit(random), 0, 0, 0, unit(random);
    const GuideResult plain = guide.goals(context, command);
    const GuideResult result = guide.goals(astray, command);
    const auto* goals = std::get_if<std::vector<Goal>>(&result);
    if (goals == nullptr || !std::holds_alternative<std::vector<Goal>>(plain)) continue;
    const Vec3 asked =
        context.from.com + rotation_z(context.from.heading()) * command.axes.head<3>() * robot_.profile().reach.trunk;
    for (const Goal& goal : *goals) {
      ASSERT_LT(rotation_error(goal.drift_correction.R, astray.drift_correction.R).norm(), 1e-12);
      // What it says to have made up for, it has: all of it, less what a step leaves.
      // That a turn of the feet moves the middle between them is neither asked for nor drift.
      Vec2 by_turn = Vec2::Zero();
      if (goal.swing) {
        const Side side = *goal.swing;
        const double turn = wrap_angle(yaw_of(goal.sole[side].R) - yaw_of(context.from.sole[side].R));
        const Vec2 arm = (goal.com - context.from.sole[other(side)].p).head<2>();
        by_turn = arm - Eigen::Rotation2Dd(-0.5 * turn) * arm;
      }
      const double left = ((goal.com - astray.drift_correction * asked).head<2>() - by_turn).norm();
      const bool there = left < kLeft * robot_.profile().stance.com_height;
      if (there) {
        EXPECT_LT(((goal.drift_correction * asked - goal.com).head<2>() + by_turn).norm(), 1e-12);
      } else {
        EXPECT_LT((goal.drift_correction * asked - asked).head<2>().norm(), (goal.com - asked).norm() * 0.01 + 1e-12);
      }
      ++(there ? led : turned);
    }
    for (const Goal& goal : std::get<std::vector<Goal>>(plain)) {
      EXPECT_TRUE(goal.drift_correction.R.isIdentity(1e-12));
      EXPECT_LT(goal.drift_correction.p.norm(), kLeft * robot_.profile().stance.com_height);
    }
    command.guide = Part::left_foot;
    const GuideResult stepping = guide.goals(astray, command);
    const auto* steps = std::get_if<std::vector<Goal>>(&stepping);
    ASSERT_TRUE(steps == nullptr || steps->front().drift_correction.p.isZero(0.0));
  }
  EXPECT_GT(led, 500);
  EXPECT_GT(turned, 100);
}

TEST_P(GuideTest, AWalkBringsTheFeetBackToTheStanceWidth) {  // soles that slip a little outward at each step, and back
  const Guide guide(robot_, flat());
  const Profile& profile = robot_.profile();
  const double size = profile.stance.com_height;
  const double nearest = 0.5 * (profile.region.foot_lateral.lo + profile.stance.width);
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  double astray = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    Posture from = home_;
    const Mat3 heading = rotation_z(3.0 * unit(random));
    const double width = profile.stance.width + 0.08 * size * std::abs(unit(random));
    const double slips = 0.002 * size * unit(random);
    for (const Side side : kSides)
      from.sole[side] = {heading * Vec3(0, 0.5 * sign_of(side) * width, 0), heading};
    from.trunk = heading;
    const Command command = push(Part::trunk, 0, trial % 2 == 0 ? 1.0 : -1.0);
    Side last = Side::right;
    for (int step = 0; step < 120; ++step) {
      GuideContext here = context(from);
      here.last_step = last;
      const Goal goal = first(guide.goals(here, command));
      const Vec3 made = heading.transpose() * (goal.com - from.com);
      const Vec3 told = heading.transpose() * goal.drift_correction.p;
      EXPECT_NEAR(told.y(), made.y(), 1e-12) << "what a step leaves is told";
      astray = std::max(astray, std::abs(made.y()));
      from.com = goal.com;
      from.sole = goal.sole;
      if (!goal.swing) continue;
      last = *goal.swing;
      const double apart = sign_of(last) * (heading.transpose() * (from.sole[last].p - from.sole[other(last)].p)).y();
      EXPECT_GT(apart, nearest - 0.004 * size) << "trial " << trial;
      from.sole[last].p += sign_of(last) * slips * heading.col(1);
    }
    const Vec3 apart = heading.transpose() * (from.sole.left.p - from.sole.right.p);
    EXPECT_NEAR(apart.y(), profile.stance.width, 0.02 * size) << "trial " << trial;
  }
  EXPECT_GT(astray, 0.002 * size);
}

TEST_P(GuideTest, AFootInTheAirIsLoweredWhenAnotherPartIsGuided) {
  const Guide guide(robot_, flat());
  Posture from = home_;
  from.contact.left = false;
  from.sole.left.p += Vec3(0.02, 0, 0.5 * robot_.profile().swing.lift);
  from.com.head<2>() = from.sole.right.p.head<2>();
  for (const Part part : {Part::right_foot, Part::trunk, Part::left_hand}) {
    const Goal goal = first(guide.goals(context(from), push(part, 0)));
    EXPECT_EQ(goal.kind, SegmentKind::lower);
    EXPECT_TRUE(goal.contact.left);
    EXPECT_NEAR(goal.sole.left.p.x(), from.sole.left.p.x(), 1e-9) << "where it is";
    EXPECT_NEAR(goal.sole.left.p.z(), 0.0, 1e-9);
  }
  // Where it may not land, it goes back to where it stood.
  GuideContext blocked = context(from);
  blocked.from.sole.left.p.y() = from.sole.right.p.y() + 0.5 * robot_.profile().region.foot_lateral.lo;
  blocked.foothold = home_.sole;
  const Goal back = first(guide.goals(blocked, push(Part::trunk, 0)));
  EXPECT_LT((back.sole.left.p - home_.sole.left.p).norm(), 1e-9);
}

TEST_P(GuideTest, TheTrunkShiftsInsideTheStandOnRegionAndStepsOutside) {
  const Guide guide(robot_, flat());
  const double reach = robot_.profile().reach.trunk;
  const Goal small = first(guide.goals(at_home(), push(Part::trunk, 0, 0.3)));
  EXPECT_EQ(small.kind, SegmentKind::shift);
  EXPECT_NEAR(small.com.x(), home_.com.x() + 0.3 * reach, 1e-9);
  const Goal large = first(guide.goals(at_home(), push(Part::trunk, 0, 1.0)));
  EXPECT_EQ(large.kind, SegmentKind::step);
  EXPECT_EQ(*large.swing, Side::left) << "at a tie the foot that did not step last";
  EXPECT_NEAR(large.sole.left.p.x(), 2.0 * reach, 1e-9);
  GuideContext stepped = at_home();
  stepped.last_step = Side::left;
  EXPECT_EQ(*first(guide.goals(stepped, push(Part::trunk, 0, 1.0))).swing, Side::right);
}

TEST_P(GuideTest, FeetOfAHeldStickPassEachOther) {
  const Guide guide(robot_, flat());
  const double reach = robot_.profile().reach.trunk;
  for (const double deflection : {1.0, -1.0}) {
    const Command command = push(Part::trunk, 0, deflection);
    GuideContext walk = at_home();
    Side stepped = walk.last_step;
    for (int k = 0; k < 6; ++k) {
      const Goal goal = first(guide.goals(walk, command));
      ASSERT_EQ(goal.kind, SegmentKind::step);
      EXPECT_EQ(*goal.swing, other(stepped));
      stepped = *goal.swing;
      // Each foot lands as far ahead of the other one, so but for the first step the trunk moves twice the
      // displacement.
      const double ahead = goal.sole[stepped].p.x() - goal.sole[other(stepped)].p.x();
      EXPECT_NEAR(ahead, 2.0 * deflection * reach, 1e-9);
      EXPECT_NEAR(goal.com.x() - walk.from.com.x(), (k == 0 ? 1.0 : 2.0) * deflection * reach, 1e-9);
      walk.from.sole = goal.sole;
      walk.from.com = goal.com;
      walk.last_step = stepped;
      walk.stick_held = true;
    }
  }
}

TEST_P(GuideTest, AHeldStickMovesTheTrunkFromOneToTwoDisplacementsStraightOn) {
  const Guide guide(robot_, flat());
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int farther = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    GuideContext walk = context(random_stance(random));
    Target target{.part = Part::trunk};
    target.move.head<2>() = robot_.profile().reach.trunk * Vec2(unit(random), unit(random));
    target.move[5] = 0.05 * unit(random);
    // What the feet allow is not asked here, so the goal that shifts the trunk is looked at.
    const auto shift = [&](bool held) -> std::optional<Vec2> {
      walk.stick_held = held;
      const GuideResult result = guide.goals(walk, target);
      if (const auto* goals = std::get_if<std::vector<Goal>>(&result)) {
        for (const Goal& goal : *goals) {
          if (goal.kind == SegmentKind::shift) return Vec2((goal.com - walk.from.com).head<2>());
        }
      }
      return std::nullopt;
    };
    const std::optional<Vec2> once = shift(false);
    const std::optional<Vec2> held = shift(true);
    if (!once || !held) continue;
    const double ratio = held->norm() / once->norm();
    EXPECT_GE(ratio, 1.0 - 1e-9);
    EXPECT_LE(ratio, 2.0 + 1e-9);
    EXPECT_GT(held->normalized().dot(once->normalized()), 1.0 - 1e-9) << "in the direction of the stick";
    farther += ratio > 1.1;
  }
  EXPECT_GT(farther, 100);
}

TEST_P(GuideTest, TurningMakesAStepInPlaceDue) {
  const Guide guide(robot_, flat());
  const Goal turn = first(guide.goals(at_home(), push(Part::trunk, 5, 1.0)));
  EXPECT_EQ(turn.kind, SegmentKind::step);
  EXPECT_GT(yaw_of(turn.sole[*turn.swing].R), 0.1);
  const Goal look = first(guide.goals(at_home(), push(Part::trunk, 5, 0.5)));
  EXPECT_EQ(look.kind, SegmentKind::shift) << "a small turn needs no step";
}

// For many turns: once the feet's places stayed where they were, ahead of each other in the end.
TEST_P(GuideTest, FeetThatTurnOnTheSpotStayBesideEachOther) {
  const Guide guide(robot_, flat());
  const double height = robot_.profile().stance.com_height;
  for (const double direction : {1.0, -1.0}) {
    GuideContext turn = at_home();
    const Vec2 spot = turn.from.com.head<2>();
    for (int k = 0; k < 60; ++k) {
      const Goal goal = first(guide.goals(turn, push(Part::trunk, 5, direction)));
      ASSERT_EQ(goal.kind, SegmentKind::step) << k;
      const Vec3 apart = rotation_z(-mean_yaw(goal.sole)) * (goal.sole.left.p - goal.sole.right.p);
      EXPECT_LT(std::abs(apart.x()), 0.01 * height) << k;
      EXPECT_NEAR(apart.y(), robot_.profile().stance.width, 0.02 * height) << k;
      EXPECT_LT((goal.com.head<2>() - spot).norm(), 0.2 * height) << k;
      turn.from.sole = goal.sole;
      turn.from.com = goal.com;
      turn.from.trunk = goal.trunk;
      turn.last_step = *goal.swing;
      turn.stick_held = true;
    }
  }
}

TEST_P(GuideTest, HeightsAreClampedAndOnlyVerticalCommandsChangeThem) {
  const Guide guide(robot_, flat());
  const Profile::Region& region = robot_.profile().region;
  Posture high = home_;
  high.com.z() = region.com_height.hi;
  EXPECT_TRUE(refused_for(guide.goals(context(high), push(Part::trunk, 2, 1.0)), Reason::com_height));
  Posture nearly = home_;
  nearly.com.z() = region.com_height.hi - 0.1 * robot_.profile().reach.trunk;
  EXPECT_NEAR(first(guide.goals(context(nearly), push(Part::trunk, 2, 1.0))).com.z(), region.com_height.hi, 1e-9);
  EXPECT_NEAR(first(guide.goals(at_home(), push(Part::trunk, 0, 1.0))).com.z(), home_.com.z(), 1e-9);
  Posture leaning = home_;
  leaning.trunk = rotation_exp({0, region.trunk_inclination - 0.01, 0});
  EXPECT_TRUE(refused_for(guide.goals(context(leaning), push(Part::trunk, 4, 1.0)), Reason::trunk_inclination));
  EXPECT_TRUE(std::holds_alternative<std::vector<Goal>>(guide.goals(context(leaning), push(Part::trunk, 4, -1.0))));
}

TEST_P(GuideTest, ATrunkThatIsLowOrLeansMayRiseToStep) {
  const Guide guide(robot_, flat());
  const Profile& profile = robot_.profile();
  Posture low = home_;
  low.com.z() = profile.region.com_height.lo;
  low.trunk = rotation_exp({0, 0.5 * profile.region.trunk_inclination, 0});
  const GuideResult result = guide.goals(context(low), push(Part::trunk, 0));
  const auto& goals = std::get<std::vector<Goal>>(result);
  ASSERT_GE(goals.size(), 3U);
  EXPECT_NEAR(goals.front().com.z(), low.com.z(), 1e-9) << "what was asked for comes first";
  const Goal& higher = goals[goals.size() - 2];
  const Goal& upright = goals.back();
  EXPECT_NEAR(higher.com.z(), profile.stance.com_height, 1e-9);
  EXPECT_EQ(higher.trunk, goals.front().trunk);
  EXPECT_NEAR(upright.com.z(), profile.stance.com_height, 1e-9);
  EXPECT_NEAR(tilt_of(upright.trunk), 0.0, 1e-9);
  // Whoever stands as at the start has nothing else to try.
  const GuideResult simple = guide.goals(at_home(), push(Part::left_foot, 0, 0.5));
  EXPECT_EQ(std::get<std::vector<Goal>>(simple).size(), 1U);
}

TEST_P(GuideTest, AHandPullsTheBodyAlongOnlyWhenItIsStretched) {
  const Guide guide(robot_, flat());
  const Profile& profile = robot_.profile();
  const double length = (home_.hand.left.p - home_.shoulder.left).norm();
  ASSERT_LT(length, profile.region.hand_distance);
  const Goal near = first(guide.goals(at_home(), push(Part::left_hand, 0, -0.2)));
  EXPECT_EQ(near.kind, SegmentKind::reach);
  EXPECT_EQ(near.com, home_.com);
  Command forward_and_down = push(Part::left_hand, 0, 1.0);
  forward_and_down.axes[2] = -1.0;
  const Goal far = first(guide.goals(at_home(), forward_and_down));
  const Vec3 hand = home_.hand.left.p + Vec3(profile.reach.hand, 0, -profile.reach.hand);
  const Vec3 stretch = hand - home_.shoulder.left;
  ASSERT_GT(stretch.norm(), profile.region.hand_distance);
  const Vec3 follow = (stretch.norm() - profile.region.hand_distance) / stretch.norm() * stretch;
  EXPECT_LT((far.com - home_.com - follow).norm(), 1e-9);
  EXPECT_LT((far.hand.left->p - hand).norm(), 1e-12);
  EXPECT_FALSE(far.hand.right.has_value()) << "the opposite hand keeps its pose relative to the trunk";
}

TEST(GuideInTheRoom, FootholdsLieOnTheGroundThereAndNotOnEdges) {
  const RobotModel& robot = test::robot("mighty");
  const Guide guide(robot, room());
  const Posture home = stand(robot, room().site("start"), robot.profile().stance.com_height);
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int stepped = 0;
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Posture from = home;
    const Vec3 shift(0.06 + 0.01 * unit(random), 0.05 * unit(random), 0);
    for (const Side side : kSides)
      from.sole[side].p += shift;
    from.com += shift;
    from.sole.left.p.x() += 0.045 * unit(random) - 0.03;
    Command command;
    command.guide = trial % 2 == 0 ? Part::left_foot : Part::trunk;
    command.axes[0] = unit(random);
    command.axes[1] = 0.2 * unit(random);
    const GuideResult result = guide.goals({from, Pose{}, Side::right, from.sole}, command);
    if (const auto* refusal = std::get_if<Refusal>(&result)) {
      ++refused;
      EXPECT_TRUE(refusal->reason == Reason::ground || refusal->reason == Reason::foot_region ||
                  refusal->reason == Reason::sole_gap || refusal->reason == Reason::no_progress)
          << to_string(refusal->reason);
    }
    const auto* goals = std::get_if<std::vector<Goal>>(&result);
    if (goals == nullptr) continue;
    for (const Goal& goal : *goals) {
      if (!goal.swing) continue;
      const Pose& sole = goal.sole[*goal.swing];
      const ConvexPolygon outline = sole_outline(robot, *goal.swing, sole);
      for (const Vec2& corner : outline.vertices()) {
        const auto ground = room().ground(corner);
        ASSERT_TRUE(ground.has_value());
        EXPECT_NEAR(ground->height, sole.p.z(), 1e-9);
        EXPECT_GE(ground->edge, 0.99 * robot.profile().margin.edge);
      }
      const double height = goal.com.z() - 0.5 * (goal.sole.left.p.z() + goal.sole.right.p.z());
      EXPECT_NEAR(height, home.com.z() - home.support_height(), 1e-9) << "the COM keeps its height above the soles";
      ++stepped;
    }
  }
  EXPECT_GT(stepped, 500);
  EXPECT_GT(refused, 50);
}

TEST(GuideInTheRoom, AFootMayGoBackToWhereItStoodThoughThatIsNearAnEdge) {
  const RobotModel& robot = test::robot("mighty");
  const Guide guide(robot, room());
  Posture from = stand(robot, room().site("start"), robot.profile().stance.com_height);
  double toe = 0.0;
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    toe = std::max(toe, vertex.x());
  const double within_margin = 0.12 - 0.5 * robot.profile().margin.edge;  // the stage ends at 0.12
  for (const Side side : kSides)
    from.sole[side].p.x() = within_margin - toe;
  const Pose stood = from.sole.left;
  from.contact.left = false;
  from.sole.left.p += Vec3(0.02, 0, 0.02);  // over the edge, where it cannot come down
  GuideContext context{from, Pose{}, Side::right, from.sole};
  context.foothold.left = stood;
  const GuideResult result = guide.landings(context, Side::left);
  const auto* goals = std::get_if<std::vector<Goal>>(&result);
  ASSERT_NE(goals, nullptr);
  const auto back = std::find_if(goals->begin(), goals->end(), [](const Goal& goal) { return goal.returns; });
  ASSERT_NE(back, goals->end());
  EXPECT_LT((back->sole.left.p - stood.p).norm(), 1e-9);
}

TEST(GuideInTheRoom, TheLessSureThePlaceTheFartherFromEdges) {
  const RobotModel& robot = test::robot("mighty");
  const Guide guide(robot, room());
  const Posture from = stand(robot, room().site("start"), robot.profile().stance.com_height);
  double toe = 0.0;
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    toe = std::max(toe, vertex.x());
  const double edge = 0.12 - robot.profile().margin.edge - toe;  // the stage ends at 0.12
  for (const double unsure : {0.0, 0.01, 0.025}) {
    for (const double nearer : {-1e-4, 1e-4}) {
      GuideContext context{from, Pose{}, Side::right, from.sole};
      context.place_uncertainty = unsure;
      Command step;
      step.guide = Part::left_foot;
      step.axes[0] = (edge - 0.1 * unsure + nearer - from.sole.left.p.x()) / robot.profile().reach.foot;
      while (std::abs(step.axes[0]) > 1.0) {  // within reach of it
        const double closer = std::copysign(robot.profile().reach.foot, step.axes[0]);
        for (const Side side : kSides)
          context.from.sole[side].p.x() += closer;
        context.from.com.x() += closer;
        step.axes[0] -= std::copysign(1.0, step.axes[0]);
      }
      const GuideResult result = guide.goals(context, step);
      const auto* goals = std::get_if<std::vector<Goal>>(&result);
      ASSERT_EQ(goals != nullptr, nearer < 0.0) << unsure;
      if (goals == nullptr) {
        EXPECT_EQ(std::get<Refusal>(result).reason, Reason::ground);
      } else {
        EXPECT_EQ(goals->front().place_uncertainty, unsure);  // as far from edges it is verified, too
      }
    }
  }
}

TEST(GuideInTheRoom, TheTrunkWalksDownTheStepFromItsEdge) {
  const RobotModel& robot = test::robot("mighty");
  const Guide guide(robot, room());
  Posture from = stand(robot, room().site("start"), robot.profile().stance.com_height);
  const Vec3 to_edge(0.0675, 0, 0);  // the soles end 3 mm before it
  for (const Side side : kSides)
    from.sole[side].p += to_edge;
  from.com += to_edge;
  Command forward;
  forward.axes[0] = 1.0;
  const GuideResult result = guide.goals({from, Pose{}, Side::right, from.sole}, forward);
  const auto* goals = std::get_if<std::vector<Goal>>(&result);
  ASSERT_NE(goals, nullptr);
  ASSERT_TRUE(goals->front().swing.has_value());
  const Pose& sole = goals->front().sole[*goals->front().swing];
  EXPECT_NEAR(sole.p.z(), 0.015, 1e-9);
  EXPECT_GE(sole.p.x() - from.sole.left.p.x(), 0.1);
}

TEST_P(GuideTest, OnlyAStanceLongerThanAStrideIsClosed) {
  const Guide guide(robot_, flat());
  const Profile::Region& region = robot_.profile().region;
  std::mt19937_64 random(23);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto ahead = [](const BySide<Pose>& sole) {
    return (rotation_z(-mean_yaw(sole)) * (sole.left.p - sole.right.p)).x();
  };
  int closed = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Posture from = random_stance(random);
    const double far = region.foot_x.hi * unit(random);
    from.sole.right.p += rotation_z(mean_yaw(from.sole)) * Vec3(ahead(from.sole) - far, 0, 0);
    const std::vector<Goal> steps = guide.closing_steps(context(from), trial % 2 == 0);
    const bool is_long = std::abs(ahead(from.sole)) > region.stride + 0.02 * robot_.profile().stance.com_height;
    const bool is_short = std::abs(ahead(from.sole)) < region.stride;
    EXPECT_FALSE(is_short && !steps.empty()) << ahead(from.sole);
    EXPECT_FALSE(is_long && steps.empty()) << ahead(from.sole);
    for (const Goal& goal : steps) {
      ASSERT_EQ(goal.kind, SegmentKind::step);
      EXPECT_LT(std::abs(ahead(goal.sole)), region.stride);
      const Side stance = other(*goal.swing);
      EXPECT_EQ(goal.sole[stance].p, from.sole[stance].p);
      ++closed;
    }
    from.contact[trial % 2 == 0 ? Side::left : Side::right] = false;
    EXPECT_TRUE(guide.closing_steps(context(from), true).empty());
  }
  EXPECT_GT(closed, 200);
}

}  // namespace
}  // namespace baton
