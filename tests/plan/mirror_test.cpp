/// Left and right are alike: to the mirrored task guide, planner and verifier give the mirrored answer.
///
/// In exact arithmetic it would be the very same. What remains is rounding: a sum that is taken from the left foot to
/// the right one is taken the other way round. Inverse kinematics, quadratic programs and durations are found by
/// counted iterations that both take alike, so they hardly amplify it. The tolerances leave room for other compilers.
///
/// One tie knows no last step, and is left out here: `Guide::catches`, of a robot pushed straight ahead with its COM
/// exactly as far from both feet, takes the right foot.
#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "baton/guide/guide.hpp"
#include "baton/ik/stand.hpp"
#include "baton/plan/planner.hpp"
#include "tests/guide/commands.hpp"
#include "tests/support/mirror.hpp"
#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

using test::Mirror;

constexpr double kGoal = 1e-9;   ///< of goals: closed forms [m, rad]
constexpr double kPlan = 1e-9;   ///< of planned paths: they were 1e-13 apart [m, rad]
constexpr double kShare = 1e-7;  ///< of values in certificates and refusals, accelerations among them, relative: 1e-13

class MirrorTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::symmetric_robot(GetParam());
  const Mirror mirror_{robot_};
  const World flat_ = World::load("flat");
  const Guide guide_{robot_, flat_};
  const Limits limits_ = Limits::normal(robot_.profile());

  static void expect_near(const Pose& a, const Pose& b, double tolerance, const char* what) {
    EXPECT_LE((a.p - b.p).norm(), tolerance) << what;
    EXPECT_LE((a.R - b.R).norm(), tolerance) << what;
  }

  static void expect_same(const Goal& a, const Goal& b) {
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.guided, b.guided);
    EXPECT_EQ(a.swing, b.swing);
    EXPECT_EQ(a.returns, b.returns);
    EXPECT_NEAR(a.place_uncertainty, b.place_uncertainty, kGoal);
    expect_near(a.drift_correction, b.drift_correction, kGoal, "back");
    EXPECT_LE((a.com - b.com).norm(), kGoal) << "com";
    EXPECT_LE((a.trunk - b.trunk).norm(), kGoal) << "trunk";
    EXPECT_LE((a.arms - b.arms).norm(), kGoal) << "arms";
    for (const Side side : kSides) {
      EXPECT_EQ(a.contact[side], b.contact[side]);
      expect_near(a.sole[side], b.sole[side], kGoal, "sole");
      ASSERT_EQ(a.hand[side].has_value(), b.hand[side].has_value());
      if (a.hand[side]) expect_near(*a.hand[side], *b.hand[side], kGoal, "hand");
    }
  }

  /// @param mirrored the answer to the mirrored task
  static void expect_mirrored(const Refusal& refusal, const Refusal& mirrored, double tolerance) {
    EXPECT_EQ(mirrored.reason, refusal.reason) << to_string(refusal.reason) << ", " << to_string(mirrored.reason);
    EXPECT_EQ(mirrored.part, Mirror::of(refusal.part));
    EXPECT_EQ(mirrored.cause, refusal.cause);
    EXPECT_NEAR(mirrored.value, refusal.value, tolerance * std::max(1.0, std::abs(refusal.value)));
    EXPECT_NEAR(mirrored.limit, refusal.limit, tolerance * std::max(1.0, std::abs(refusal.limit)));
    EXPECT_NEAR(mirrored.t, refusal.t, 1e-9);
  }

  void expect_mirrored(const GuideResult& result, const GuideResult& mirrored) const {
    ASSERT_EQ(mirrored.index(), result.index());
    if (const auto* goals = std::get_if<std::vector<Goal>>(&result)) {
      const auto& others = std::get<std::vector<Goal>>(mirrored);
      ASSERT_EQ(others.size(), goals->size());
      for (std::size_t i = 0; i < goals->size(); ++i)
        expect_same(others[i], mirror_.of((*goals)[i]));
    } else if (const auto* refusal = std::get_if<Refusal>(&result)) {
      expect_mirrored(*refusal, std::get<Refusal>(mirrored), kGoal);
    }
  }

  static void expect_mirrored(const Target& target, const Target& mirrored) {
    const Target other = Mirror::of(target);
    EXPECT_EQ(mirrored.part, other.part);
    EXPECT_LE((mirrored.move - other.move).norm(), kGoal);
    EXPECT_NEAR(mirrored.lift, other.lift, kGoal);
  }

  static void expect_mirrored(const Certificate& certificate, const Certificate& mirrored) {
    ASSERT_EQ(mirrored.margins.size(), certificate.margins.size());
    for (std::size_t i = 0; i < certificate.margins.size(); ++i) {
      const Margin& a = certificate.margins[i];
      const Margin& b = mirrored.margins[i];
      EXPECT_EQ(b.quantity, a.quantity);
      EXPECT_NEAR(b.value, a.value, kShare * std::max(std::abs(a.limit), std::abs(a.value))) << to_string(a.quantity);
      EXPECT_NEAR(b.limit, a.limit, kGoal) << to_string(a.quantity);
    }
  }

  void expect_mirrored(const PlanResult& result, const PlanResult& mirrored) const {
    ASSERT_EQ(mirrored.index(), result.index());
    if (const auto* refusal = std::get_if<Refusal>(&result)) {
      expect_mirrored(*refusal, std::get<Refusal>(mirrored), kShare);
      return;
    }
    const auto& a = std::get<PlannedMotion>(result);
    const auto& b = std::get<PlannedMotion>(mirrored);
    EXPECT_EQ(b.durations_tried, a.durations_tried);
    ASSERT_EQ(b.motion->ticks(), a.motion->ticks());
    ASSERT_EQ(b.motion->phases.size(), a.motion->phases.size());
    for (std::size_t i = 0; i < a.motion->phases.size(); ++i)
      EXPECT_EQ(b.motion->phases[i].ticks, a.motion->phases[i].ticks);
    double com = 0.0;
    double angle = 0.0;
    for (std::size_t k = 0; k < a.motion->samples.size(); ++k) {
      const MotionSample& s = a.motion->samples[k];
      const MotionSample& m = b.motion->samples[k];
      EXPECT_EQ(m.contact.left, s.contact.right);
      EXPECT_EQ(m.contact.right, s.contact.left);
      const double t = static_cast<double>(k) * a.motion->period;
      com = std::max(com, (b.motion->com.at(t).p - Mirror::of(a.motion->com.at(t).p)).norm());
      com = std::max(com, (m.com - Mirror::of(s.com)).norm());
      angle = std::max(angle, (m.q - mirror_.configuration(s.q)).cwiseAbs().maxCoeff());
    }
    EXPECT_LE(com, kPlan);
    EXPECT_LE(angle, kPlan);
    expect_mirrored(a.motion.certificate(), b.motion.certificate());
    ASSERT_EQ(b.not_shorter.has_value(), a.not_shorter.has_value());
    if (a.not_shorter) expect_mirrored(*a.not_shorter, *b.not_shorter, kShare);
  }

  /// Home, where the robot is its own mirror image.
  [[nodiscard]] Posture home() const {
    const Posture stood = stand(robot_, Pose{}, robot_.profile().stance.com_height);
    Posture posture = posture_of(robot_, 0.5 * (stood.q + mirror_.configuration(stood.q)));
    posture.com.y() = 0.0;
    posture.trunk = Mat3::Identity();
    posture.sole.right = Mirror::of(posture.sole.left);
    posture.hand.right = Mirror::of(posture.hand.left);
    posture.shoulder.right = Mirror::of(posture.shoulder.left);
    return posture;
  }

  /// What rules may meet: soles anywhere in their region, one in the air or on its way, the trunk leaning, a place that
  /// is not sure, soles that slid.
  [[nodiscard]] GuideContext random_context(std::mt19937_64& random) const {
    const Profile::Region& region = robot_.profile().region;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto either = [&] { return 2.0 * unit(random) - 1.0; };
    GuideContext context;
    Posture& from = context.from;
    from = home();
    const Side moved = random() % 2 == 0 ? Side::left : Side::right;
    const double lateral =
        region.foot_lateral.lo + 0.5 * unit(random) * (region.foot_lateral.hi - region.foot_lateral.lo);
    from.sole[moved] = from.sole[other(moved)] *
                       Pose{Vec3(either() * region.stride, sign_of(moved) * lateral, 0), rotation_z(0.1 * either())};
    const double height = region.com_height.lo + unit(random) * (region.com_height.hi - region.com_height.lo);
    from.com = 0.5 * (from.sole.left.p + from.sole.right.p) + Vec3(0.01 * either(), 0.01 * either(), height);
    const double lean = 1.5 * region.trunk_inclination * std::max(0.0, either());
    from.trunk = rotation_exp(rotation_z(6.0 * unit(random)) * Vec3(lean, 0, 0)) * rotation_z(0.2 * either());
    for (const Side side : kSides) {
      from.hand[side].p += 0.02 * Vec3(either(), either(), either());
      from.hand[side].R = rotation_exp(0.2 * Vec3(either(), either(), either())) * from.hand[side].R;
    }
    context.last_step = random() % 2 == 0 ? Side::left : Side::right;
    context.foothold = from.sole;
    context.anchor = {Vec3(either(), either(), 0), rotation_z(3.0 * either())};
    context.slip_free_frame = context.anchor;
    context.stick_held = random() % 2 == 0;
    if (random() % 3 == 0) context.place_uncertainty = 0.005 * unit(random);
    if (random() % 3 == 0) context.drift_correction = {0.01 * Vec3(either(), either(), 0), rotation_z(0.02 * either())};
    switch (random() % 4) {
      case 0:  // in the air
        from.contact[moved] = false;
        from.contact_before[moved] = false;
        from.sole[moved].p += Vec3(0.01 * either(), 0.01 * either(), 0.5 * robot_.profile().swing.lift);
        break;
      case 1:  // on its way
        context.step = GuideContext::Step{moved, from.sole[moved]};
        context.step->to.p += Vec3(0.02 * either(), 0, 0);
        break;
      default:
        break;
    }
    return context;
  }

  [[nodiscard]] static Command random_command(std::mt19937_64& random) {
    Command command = test::random_command(random);
    if (random() % 10 == 0) command.recall = Recall::home;
    return command;
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, MirrorTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(MirrorTest, TheRobotIsItsOwnMirrorImage) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Kinematics kinematics(robot_);
  for (int trial = 0; trial < 100; ++trial) {
    VecX q = stand(robot_, Pose{}, robot_.profile().stance.com_height).q;
    for (std::size_t i = 0; i < robot_.joints().size(); ++i)
      q[7 + static_cast<Eigen::Index>(i)] += 0.3 * unit(random);
    const VecX dq = VecX::NullaryExpr(robot_.nv(), [&] { return unit(random); });
    const VecX ddq = VecX::NullaryExpr(robot_.nv(), [&] { return 10.0 * unit(random); });
    const Posture a = mirror_.of(posture_of(robot_, q));
    const Posture b = posture_of(robot_, mirror_.configuration(q));
    EXPECT_LE((a.com - b.com).norm(), 1e-9);
    for (const Side side : kSides) {
      expect_near(a.sole[side], b.sole[side], 1e-9, "sole");
      expect_near(a.hand[side], b.hand[side], 1e-9, "hand");
      EXPECT_LE((a.shoulder[side] - b.shoulder[side]).norm(), 1e-9);
    }
    VecX force(robot_.nv());
    VecX mirrored(robot_.nv());
    kinematics.inverse_dynamics(q, dq, ddq, force);
    kinematics.inverse_dynamics(mirror_.configuration(q), mirror_.velocity(dq), mirror_.velocity(ddq), mirrored);
    EXPECT_LE((mirror_.velocity(force) - mirrored).norm(), 1e-6 * (1.0 + force.norm()));
  }
  const auto in_order = [](double a, double b) { return std::abs(a - b) < 1e-9; };
  VecX lo(robot_.joints().size());
  VecX stall(robot_.joints().size());
  for (std::size_t i = 0; i < robot_.joints().size(); ++i) {
    lo[static_cast<Eigen::Index>(i)] = robot_.joints()[i].home;
    stall[static_cast<Eigen::Index>(i)] = robot_.joints()[i].motor.stall;
  }
  EXPECT_TRUE(in_order((mirror_.joints(lo) - lo).norm(), 0.0)) << "arms at home";
  EXPECT_TRUE(in_order((mirror_.joints(stall).cwiseAbs() - stall).norm(), 0.0)) << "motors";
}

TEST_P(MirrorTest, TheRulesGiveTheMirroredGoalsInTheSameOrder) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::array<int, 3> seen{};
  for (int trial = 0; trial < 600; ++trial) {
    const GuideContext context = random_context(random);
    const GuideContext mirrored = mirror_.of(context);
    const Command command = random_command(random);
    const Command other = Mirror::of(command);
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", " << to_string(command.guide));
    const GuideResult goals = guide_.goals(context, command);
    ++seen.at(goals.index());
    expect_mirrored(goals, guide_.goals(mirrored, other));
    const std::optional<Target> whole = guide_.target(context, command);
    const std::optional<Target> opposite = guide_.target(mirrored, other);
    ASSERT_EQ(opposite.has_value(), whole.has_value());
    if (whole) {
      const Target& whole_mirrored = *opposite;
      expect_mirrored(*whole, whole_mirrored);
      expect_mirrored(guide_.part_of(context, *whole, 0.5), guide_.part_of(mirrored, whole_mirrored, 0.5));
      const std::vector<Target> singles = guide_.single_axes(*whole);
      const std::vector<Target> singles_mirrored = guide_.single_axes(whole_mirrored);
      ASSERT_EQ(singles_mirrored.size(), singles.size());
      for (std::size_t i = 0; i < singles.size(); ++i)
        expect_mirrored(singles[i], singles_mirrored[i]);
      if (is_foot(command.guide)) {
        expect_mirrored(guide_.within_region(context, *whole), guide_.within_region(mirrored, whole_mirrored));
        expect_mirrored(guide_.nearest_step(context, *whole), guide_.nearest_step(mirrored, whole_mirrored));
        expect_mirrored(guide_.other_foot_first(context, *whole), guide_.other_foot_first(mirrored, whole_mirrored));
      }
    }
    for (const Side side : kSides) {
      if (!context.from.contact[side])
        expect_mirrored(guide_.landings(context, side), guide_.landings(mirrored, baton::other(side)));
    }
    const Vec2 by = 0.05 * Vec2(unit(random), unit(random));
    for (const bool aside : {false, true})
      expect_mirrored(guide_.capture_steps(context, by, aside), guide_.capture_steps(mirrored, Mirror::of(by), aside));
    expect_mirrored(guide_.stops(context), guide_.stops(mirrored));
    if (HasFailure()) return;
  }
  EXPECT_GT(seen[1], 200) << "goals";
  EXPECT_GT(seen[2], 20) << "refusals";
}

TEST_P(MirrorTest, WhereBothFeetAreAlikeTheLastStepDecides) {
  // At home the robot is its own mirror image, so a tie can be broken only by the foot that stepped last.
  GuideContext context;
  context.from = home();
  context.foothold = context.from.sole;
  int stepped = 0;
  for (const Part part : kParts) {
    for (int axis = 0; axis < 6; ++axis) {
      for (const double value : {1.0, -1.0}) {
        for (const bool stick_held : {false, true}) {
          Command command;
          command.guide = part;
          command.axes[axis] = value;
          context.stick_held = stick_held;
          SCOPED_TRACE(testing::Message() << to_string(part) << ", axis " << axis << ", " << value);
          std::array<GuideResult, 2> results;
          for (const Side last : kSides) {
            context.last_step = last;
            results.at(last == Side::left ? 0 : 1) = guide_.goals(context, command);
            expect_mirrored(guide_.goals(context, command), guide_.goals(mirror_.of(context), Mirror::of(command)));
          }
          // What is no matter of sides asks for the other foot.
          const auto* after_left = std::get_if<std::vector<Goal>>(results.data());
          const auto* after_right = std::get_if<std::vector<Goal>>(&results[1]);
          if (part == Part::trunk && axis == 0 && after_left != nullptr && after_right != nullptr) {
            ASSERT_EQ(after_left->size(), after_right->size());
            for (std::size_t i = 0; i < after_left->size(); ++i) {
              if (!(*after_left)[i].swing) continue;
              ++stepped;
              EXPECT_EQ((*after_right)[i].swing, Mirror::of((*after_left)[i].swing));
            }
          }
          if (HasFailure()) return;
        }
      }
    }
  }
  EXPECT_GT(stepped, 0);
}

TEST_P(MirrorTest, PlansAndTheirVerificationAreMirrored) {
  Planner planner(robot_, flat_);
  Verifier verifier(robot_, flat_);
  std::mt19937_64 random(3);
  GuideContext context = test::at_home(robot_);
  int planned = 0;
  int refused = 0;
  int refuted = 0;
  for (std::size_t k = 0; k < 80; ++k) {
    const Command command = test::in_turn(k, random);
    const GuideResult guided = guide_.goals(context, command);
    const auto* goals = std::get_if<std::vector<Goal>>(&guided);
    if (goals == nullptr) continue;
    // Weak motors now and then, so that durations are corrected and plans refused.
    Limits limits = limits_;
    if (k % 4 == 3) limits.torque *= 0.6;
    const DurationRule rule = k % 2 == 0 ? DurationRule::paper : DurationRule::search;
    SCOPED_TRACE(testing::Message() << "segment " << k << ", " << to_string(command.guide) << ", "
                                    << to_string(goals->front().kind));
    const PlanResult plan = planner.plan(context.from, goals->front(), context.anchor, limits, rule);
    expect_mirrored(plan, planner.plan(mirror_.of(context.from), mirror_.of(goals->front()), Mirror::of(context.anchor),
                                       limits, rule));
    if (HasFailure()) return;
    if (const auto* found = std::get_if<PlannedMotion>(&plan)) {
      ++planned;
      const Motion mirrored = mirror_.of(*found->motion);
      const auto again = verifier.verify(mirrored, Mirror::of(context.anchor), limits);
      ASSERT_TRUE(std::holds_alternative<VerifiedMotion>(again)) << to_string(std::get<Refusal>(again).reason);
      expect_mirrored(found->motion.certificate(), std::get<VerifiedMotion>(again).certificate());
      // Each limit in turn too strict for it.
      for (const auto& strict : std::array<std::function<void(Limits&)>, 5>{
               [](Limits& l) { l.torque *= 0.2; }, [](Limits& l) { l.zmp_verify += 0.02; },
               [](Limits& l) { l.acceleration *= 0.1; }, [](Limits& l) { l.friction *= 0.1; },
               [](Limits& l) { l.self_collision += 0.02; }}) {
        Limits strictly = limits;
        strict(strictly);
        const auto a = verifier.verify(*found->motion, context.anchor, strictly);
        const auto b = verifier.verify(mirrored, Mirror::of(context.anchor), strictly);
        ASSERT_EQ(b.index(), a.index());
        if (const auto* refusal = std::get_if<Refusal>(&a)) {
          ++refuted;
          expect_mirrored(*refusal, std::get<Refusal>(b), kShare);
        } else {
          expect_mirrored(std::get<VerifiedMotion>(a).certificate(), std::get<VerifiedMotion>(b).certificate());
        }
      }
      if (HasFailure()) return;
      test::go_on(context, *found->motion);
      if (found->motion->goal.swing) context.last_step = *found->motion->goal.swing;
    } else {
      ++refused;
    }
  }
  EXPECT_GT(planned, 30);
  EXPECT_GT(refused, 2);
  EXPECT_GT(refuted, 50);
}

}  // namespace
}  // namespace baton
