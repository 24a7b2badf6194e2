#include "baton/verify/verifier.hpp"
#include "tests/support/temp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <random>
#include <stdexcept>
#include <type_traits>

#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class VerifierTest : public testing::TestWithParam<std::string> {
 protected:
  /// The first sample motion that has a single support.
  [[nodiscard]] Motion step() const { return *verified_step(); }
  [[nodiscard]] VerifiedMotion verified_step() const {
    for (const VerifiedMotion& motion : motions_) {
      if (motion->goal.kind == SegmentKind::step) return motion;
    }
    ADD_FAILURE() << "no step among the sample motions";
    return motions_.front();
  }

  [[nodiscard]] static std::size_t middle_of_the_swing(const Motion& motion) {
    const auto& phases = motion.phases;
    return static_cast<std::size_t>(phases[0].ticks + phases[1].ticks / 2);
  }

  /// The robot with a profile that lets postures be others than the planned ones.
  [[nodiscard]] RobotModel untracked() const {
    Profile profile = robot_.profile();
    profile.ik.position = profile.ik.rotation = 100.0;
    return RobotModel(profile);
  }

  [[nodiscard]] Refusal refusal_of(Motion motion) { return refusal_of(std::move(motion), verifier_); }
  [[nodiscard]] Refusal refusal_of(Motion motion, Verifier& verifier) const {
    return refusal_of(std::move(motion), verifier, limits_);
  }
  [[nodiscard]] static Refusal refusal_of(Motion motion, Verifier& verifier, const Limits& limits) {
    const auto verdict = verifier.verify(std::move(motion), Pose{}, limits);
    if (const auto* refusal = std::get_if<Refusal>(&verdict)) return *refusal;
    ADD_FAILURE() << "verified";
    return {};
  }

  [[nodiscard]] Certificate certificate_of(Motion motion, const Pose& anchor = {}) {
    return certificate_of(std::move(motion), verifier_, limits_, anchor);
  }
  [[nodiscard]] static Certificate certificate_of(Motion motion, Verifier& verifier, const Limits& limits,
                                                  const Pose& anchor = {}) {
    const auto verdict = verifier.verify(std::move(motion), anchor, limits);
    if (const auto* verified = std::get_if<VerifiedMotion>(&verdict)) return verified->certificate();
    const Refusal& refusal = std::get<Refusal>(verdict);
    ADD_FAILURE() << "refused: " << to_string(refusal.reason) << " " << refusal.value << " " << refusal.limit;
    return {};
  }

  /// An index of the joint in q̇; it moves an arm.
  [[nodiscard]] int arm_dof() const { return 6 + robot_.arm(Side::left).back(); }
  [[nodiscard]] const Joint& arm_joint() const { return robot_.joints()[static_cast<std::size_t>(arm_dof() - 6)]; }

  const RobotModel& robot_ = test::robot(GetParam());
  const Profile::Margin& margin_ = robot_.profile().margin;
  const Limits limits_ = Limits::normal(robot_.profile());
  const std::vector<VerifiedMotion>& motions_ = test::sample_motions(GetParam());
  const World world_ = World::load("flat");
  Verifier verifier_{robot_, world_};
  const double size_ = robot_.profile().stance.com_height;
};

INSTANTIATE_TEST_SUITE_P(Robots, VerifierTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

// Nobody but the verifier makes a verified motion, or changes one.
static_assert(!std::is_default_constructible_v<VerifiedMotion> && !std::is_aggregate_v<VerifiedMotion>);
static_assert(!std::is_constructible_v<VerifiedMotion, Motion> && !std::is_constructible_v<VerifiedMotion, Motion&>);
static_assert(!std::is_constructible_v<VerifiedMotion, Motion, Certificate>);
static_assert(std::is_same_v<decltype(*std::declval<VerifiedMotion&>()), const Motion&>);
static_assert(std::is_same_v<decltype(std::declval<VerifiedMotion&>().operator->()), const Motion*>);
static_assert(std::is_same_v<decltype(std::declval<VerifiedMotion&>().certificate()), const Certificate&>);
static_assert(std::is_nothrow_move_constructible_v<VerifiedMotion> &&
              std::is_nothrow_move_assignable_v<VerifiedMotion>);

TEST_P(VerifierTest, HandlesOfAVerifiedMotionShareIt) {
  const VerifiedMotion motion = motions_.front();
  const VerifiedMotion& copy = motion;
  EXPECT_EQ(&*copy, &*motions_.front());
  // A copy of the motion is its own, and has to be verified anew.
  Motion changed = *motion;
  changed.samples[1].q[7] += 1.0;
  EXPECT_NE(changed.samples[1].q, motion->samples[1].q);
  EXPECT_TRUE(std::holds_alternative<Refusal>(verifier_.verify(std::move(changed), Pose{}, limits_)));
}

TEST_P(VerifierTest, VerifiesAgainWhatItVerified) {
  ASSERT_GT(motions_.size(), 15u);
  for (const VerifiedMotion& motion : motions_) {
    const Certificate again = certificate_of(*motion);
    ASSERT_EQ(again.margins.size(), motion.certificate().margins.size());
    for (std::size_t i = 0; i < again.margins.size(); ++i) {
      EXPECT_EQ(again.margins[i].quantity, motion.certificate().margins[i].quantity);
      EXPECT_EQ(again.margins[i].value, motion.certificate().margins[i].value);
      EXPECT_EQ(again.margins[i].t, motion.certificate().margins[i].t);
      EXPECT_GE(again.margins[i].t, 0.0);
      EXPECT_LE(again.margins[i].t, motion->duration() + 1e-12);
    }
  }
}

TEST_P(VerifierTest, DoesNotMindWhereOnAnEndlessFloorItHappens) {
  const Pose anchor{Vec3(1.5, -0.7, 0.0), rotation_z(2.0)};
  for (const VerifiedMotion& motion : motions_) {
    const Certificate there = certificate_of(*motion, anchor);
    ASSERT_EQ(there.margins.size(), motion.certificate().margins.size());
    for (std::size_t i = 0; i < there.margins.size(); ++i) {
      EXPECT_NEAR(there.margins[i].value, motion.certificate().margins[i].value, 1e-6)
          << to_string(there.margins[i].quantity);
    }
  }
}

TEST_P(VerifierTest, RefusesAJointBeyondItsLimit) {
  for (const bool upper : {true, false}) {
    Motion motion = step();
    const Joint& joint = arm_joint();
    double& q = motion.samples[3].q[1 + arm_dof()];
    q = upper ? joint.position.hi - 0.4 * margin_.joint : joint.position.lo + 0.4 * margin_.joint;
    const Refusal refusal = refusal_of(motion);
    EXPECT_EQ(refusal.reason, Reason::joint_limit) << to_string(refusal.reason);
    EXPECT_NEAR(refusal.value, 0.4 * margin_.joint, 1e-12);
    EXPECT_EQ(refusal.limit, margin_.joint);
    EXPECT_EQ(refusal.where, joint.name);
  }
}

TEST_P(VerifierTest, RefusesAJointThatIsTooFast) {
  for (const double sign : {-1.0, 1.0}) {
    Motion motion = step();
    const double speed = 1.01 * arm_joint().speed;
    motion.samples[5].dq[arm_dof()] = sign * speed;
    const Refusal refusal = refusal_of(motion);
    EXPECT_EQ(refusal.reason, Reason::joint_speed) << to_string(refusal.reason);
    EXPECT_NEAR(refusal.value, speed, 1e-12);
    EXPECT_EQ(refusal.limit, arm_joint().speed);
    EXPECT_EQ(refusal.where, arm_joint().name);
  }
}

TEST_P(VerifierTest, RefusesATorqueThatTheMotorHasNot) {
  Motion motion = step();
  MotionSample& sample = motion.samples[2];
  // For the motor's own inertia alone; that of the link comes on top.
  const double inertia = robot_.mj().dof_armature[arm_dof()];
  sample.ddq[arm_dof()] = 1.1 * arm_joint().motor.stall / inertia;
  Limits jerky = limits_;
  jerky.acceleration = 1e5;  // or that would be the reason
  const Refusal refusal = refusal_of(motion, verifier_, jerky);
  EXPECT_EQ(refusal.reason, Reason::joint_torque) << to_string(refusal.reason) << " " << refusal.value;
  EXPECT_EQ(refusal.limit, margin_.torque);
  EXPECT_EQ(refusal.where, arm_joint().name);
  Kinematics kinematics(robot_);
  VecX force(robot_.nv());
  kinematics.inverse_dynamics(sample.q, sample.dq, sample.ddq, force);
  EXPECT_NEAR(refusal.value, arm_joint().motor.load(force[arm_dof()], sample.dq[arm_dof()]), 1e-12);
  EXPECT_GT(refusal.value, 1.0);
}

TEST_P(VerifierTest, CountsTheSpeedAsABurdenOnTheMotor) {
  // What a joint moves with no force at all still takes the back-EMF of the way back.
  Motion motion = step();
  const double speed = 0.99 * arm_joint().speed;
  motion.samples[2].dq[arm_dof()] = speed;
  const Certificate certificate = certificate_of(motion);
  const double least = (arm_joint().motor.damping * speed) / arm_joint().motor.stall;
  for (const Margin& margin : certificate.margins) {
    if (margin.quantity != Reason::joint_torque) continue;
    EXPECT_GT(margin.value, least);
  }
}

TEST_P(VerifierTest, RefusesAnAccelerationSpike) {
  Motion motion = step();
  const double most = margin_.acceleration;
  motion.samples[4].ddq[arm_dof()] = -1.2 * most;
  const Refusal refusal = refusal_of(motion);
  EXPECT_EQ(refusal.reason, Reason::joint_acceleration) << to_string(refusal.reason);
  EXPECT_NEAR(refusal.value, 1.2 * most, 1e-9);
  EXPECT_EQ(refusal.limit, most);
  EXPECT_EQ(refusal.where, arm_joint().name);
}

TEST_P(VerifierTest, RefusesPosturesThatAreNotThePlannedOnes) {
  const double tolerance = robot_.profile().ik.position;
  for (int which = 0; which < 3; ++which) {
    Motion motion = step();
    MotionSample& sample = motion.samples[7];
    if (which == 0) sample.com.x() += 3.0 * tolerance;
    if (which == 1) sample.sole.left.p.z() += 3.0 * tolerance;
    if (which == 2) sample.sole.right.R = rotation_z(3.0 * robot_.profile().ik.rotation) * sample.sole.right.R;
    const Refusal refusal = refusal_of(motion);
    EXPECT_EQ(refusal.reason, Reason::unreachable) << which << ": " << to_string(refusal.reason);
    EXPECT_NEAR(refusal.value, 3.0 * tolerance, 0.05 * tolerance);
  }
}

TEST_P(VerifierTest, RefusesATrunkThatLeansTooFarUnlessItStraightensUp) {
  // Bolt upright from upright, seen by a robot that may not lean: what matters is where it is on the way.
  const Motion motion = step();
  const std::size_t middle = middle_of_the_swing(motion);
  const RobotModel untracked_robot = untracked();
  const double most = robot_.profile().region.trunk_inclination;
  const auto lean = [](Motion& moves, std::size_t tick, double angle) {
    auto q = moves.samples[tick].q.segment<4>(3);
    const Eigen::Quaterniond now(q[0], q[1], q[2], q[3]);
    const Eigen::Quaterniond leaning = Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitY())) * now;
    q << leaning.w(), leaning.x(), leaning.y(), leaning.z();
  };
  Verifier verifier(untracked_robot, world_);
  Motion leans = motion;
  lean(leans, middle, most + 0.02);
  const Refusal refusal = refusal_of(leans, verifier);
  EXPECT_EQ(refusal.reason, Reason::trunk_inclination) << to_string(refusal.reason);
  EXPECT_NEAR(refusal.value, most + 0.02, 0.01);
  // As far as it leaned at the start it may lean on the way.
  Motion straightens = motion;
  for (std::size_t tick = 0; tick <= middle; ++tick)
    lean(straightens, tick, most + 0.02);
  const auto verdict = verifier.verify(straightens, Pose{}, limits_);
  const auto* other = std::get_if<Refusal>(&verdict);
  EXPECT_TRUE(other == nullptr || other->reason != Reason::trunk_inclination);
}

TEST_P(VerifierTest, RefusesAWrenchThatNoForcesAtTheSolesGive) {
  // Ground hardly less slippery than the tangential force as a whole: the pyramids at the vertices cannot give it.
  const VerifiedMotion motion = verified_step();
  Limits slippery = limits_;
  for (const Margin& margin : motion.certificate().margins) {
    if (margin.quantity == Reason::friction) slippery.friction = 1.05 * margin.value;
  }
  const Refusal refusal = refusal_of(*motion, verifier_, slippery);
  EXPECT_EQ(refusal.reason, Reason::contact_wrench) << to_string(refusal.reason);
  EXPECT_GT(refusal.value, refusal.limit);
}

TEST_P(VerifierTest, AYawTorqueBeyondTheFrictionOfTheSolesCannotBeHad) {
  const MotionSample& sample = motions_.front()->samples.front();
  VertexForces forces(robot_, limits_);
  const double weight = robot_.mass() * kGravity;
  double lever = 0.0;
  for (const Side side : kSides) {
    for (const Vec2& v : robot_.sole(side).vertices())
      lever = std::max(lever, (sample.sole[side] * Vec3(v.x(), v.y(), 0) - sample.com).head<2>().norm());
  }
  Wrench total;
  total.force = Vec3(0, 0, weight);
  total.moment = sample.com.cross(total.force);
  EXPECT_LT(forces.missing(sample.sole, sample.contact, total, sample.com), 1e-6);
  for (const double sign : {-1.0, 1.0}) {
    Wrench turned = total;
    turned.moment.z() += sign * 1.05 * margin_.friction * weight * lever;
    EXPECT_GT(forces.missing(sample.sole, sample.contact, turned, sample.com), 1e-2);
    turned.moment.z() = total.moment.z() + sign * 0.2 * margin_.friction * weight * lever;
    EXPECT_LT(forces.missing(sample.sole, sample.contact, turned, sample.com), 1e-6);
  }
}

TEST_P(VerifierTest, VertexForcesGiveWhatForcesAtTheVerticesGive) {
  // Any wrench made of forces inside the pyramids can be had; what pulls, slips or tips cannot.
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  VertexForces forces(robot_, limits_);
  const double mu = margin_.friction / std::sqrt(2.0);
  const double weight = robot_.mass() * kGravity;
  for (int trial = 0; trial < 2000; ++trial) {
    BySide<Pose> sole;
    for (const Side side : kSides) {
      sole[side].p =
          size_ * Vec3(0.3 * uniform(random), sign_of(side) * (0.2 + 0.2 * uniform(random)), 0.2 * uniform(random));
      sole[side].R = rotation_exp(0.1 * Vec3(uniform(random), uniform(random), uniform(random)));
    }
    const BySide<bool> contact{trial % 3 != 1, trial % 3 != 2};
    const Vec3 com(0, 0, size_);
    Wrench total;
    Vec3 highest = Vec3::Zero();
    for (const Side side : kSides) {
      if (!contact[side]) continue;
      for (const Vec2& v : robot_.sole(side).inset(margin_.zmp_verify).vertices()) {
        const double normal = weight * uniform(random) / 4.0;
        const Vec3 f = sole[side].R * Vec3(mu * normal * (2.0 * uniform(random) - 1.0),
                                           mu * normal * (2.0 * uniform(random) - 1.0), normal);
        const Vec3 at = sole[side] * Vec3(v.x(), v.y(), 0);
        total.force += f;
        total.moment += at.cross(f);
        highest = at;
      }
    }
    ASSERT_LT(forces.missing(sole, contact, total, com), 1e-4) << trial;
    Wrench pulled = total;
    pulled.force.z() = -0.1 * weight;
    ASSERT_GT(forces.missing(sole, contact, pulled, com), 0.05) << trial;
    Wrench slipping = total;  // a push at a sole, stronger than friction
    const Vec3 push(1.5 * total.force.z(), 0, 0);
    slipping.force += push;
    slipping.moment += highest.cross(push);
    ASSERT_GT(forces.missing(sole, contact, slipping, com), 1e-3) << trial;
    Wrench tipping = total;
    tipping.moment.y() += 1.2 * size_ * total.force.z();
    ASSERT_GT(forces.missing(sole, contact, tipping, com), 1e-3) << trial;
  }
}

/// Ground that ends there [m].
World ledge(const std::string& name, double x, double size) {
  const auto file = std::filesystem::path(test::temp_folder()) / ("baton_ledge_" + name + ".xml");
  const double far = 10.0 * size;
  std::ofstream(file) << std::setprecision(17) << "<mujoco model=\"ledge\"><worldbody><site name=\"start\"/>\n"
                      << "<geom name=\"ground_here\" type=\"box\" pos=\"" << x - far << " 0 -1\" size=\"" << far << " "
                      << far << " 1\"/></worldbody></mujoco>\n";
  return World(file);
}

TEST_P(VerifierTest, TheLessSureThePlaceTheFartherFromEdgesALandingMustBe) {
  Motion motion = step();
  const Side swing = *motion.goal.swing;
  double toe = -1e9;
  for (const Vec2& vertex : sole_outline(robot_, swing, motion.end.sole[swing]).vertices())
    toe = std::max(toe, vertex.x());
  const World world = ledge(GetParam(), toe + 1.5 * margin_.edge, size_);
  Verifier verifier(robot_, world);
  for (const double unsure : {0.0, 0.4, 0.6, 1.0}) {
    motion.goal.place_uncertainty = 10.0 * unsure * margin_.edge;
    const auto verdict = verifier.verify(motion, Pose{}, limits_);
    ASSERT_EQ(std::holds_alternative<VerifiedMotion>(verdict), unsure < 0.5) << unsure;
    if (unsure < 0.5) continue;
    EXPECT_EQ(std::get<Refusal>(verdict).reason, Reason::ground);
  }
}

TEST_P(VerifierTest, RefusesALandingWithoutGround) {
  const Motion motion = step();
  // The ground ends under the landing sole, and goes on so that nothing else is wrong.
  const World world = ledge(GetParam(), motion.end.sole[*motion.goal.swing].p.x(), size_);
  Verifier verifier(robot_, world);
  const Refusal refusal = refusal_of(motion, verifier);
  EXPECT_EQ(refusal.reason, Reason::ground) << to_string(refusal.reason);
  EXPECT_EQ(refusal.part, foot(*motion.goal.swing));
  EXPECT_GT(refusal.value, refusal.limit);
}

TEST_P(VerifierTest, RefusesAZmpOutsideTheSupport) {
  const RobotModel anywhere = untracked();
  Verifier verifier(anywhere, world_);
  // The whole body moves off its soles.
  for (const Vec2& off : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
    Motion motion = step();
    for (MotionSample& sample : motion.samples) {
      sample.q.head<2>() += size_ * off;
      sample.com.head<2>() += size_ * off;
    }
    motion.end.q = motion.rest.q = motion.samples.back().q;
    const Refusal refusal = refusal_of(motion, verifier);
    EXPECT_EQ(refusal.reason, Reason::zmp) << to_string(refusal.reason);
    EXPECT_EQ(refusal.limit, margin_.zmp_verify);
    // Found at once; the ZMP has moved with the body.
    const MotionSample& first = motion.samples.front();
    const auto support = support_polygon(robot_, first.sole, first.contact, first.com, 0.0);
    EXPECT_NEAR(refusal.value, support.margin(step().samples.front().zmp + size_ * off), 1e-9);
  }
}

TEST_P(VerifierTest, AMotionRestsInThePostureOfItsLastSample) {
  Verifier verifier(robot_, world_);
  Motion other = step();
  other.end.q[7] += 1e-9;
  EXPECT_THROW((void)verifier.verify(other, {}, Limits::normal(robot_.profile())), std::invalid_argument);
  Motion elsewhere = step();
  elsewhere.rest.q[7] += 1e-9;
  EXPECT_THROW((void)verifier.verify(elsewhere, {}, Limits::normal(robot_.profile())), std::invalid_argument);
  Motion nowhere = step();
  nowhere.end.q.resize(0);
  EXPECT_THROW((void)verifier.verify(nowhere, {}, Limits::normal(robot_.profile())), std::invalid_argument);
}

TEST_P(VerifierTest, RefusesFrictionThatTheGroundHasNot) {
  Motion motion = step();
  MotionSample& sample = motion.samples[1];
  sample.ddq[0] = 1.2 * margin_.friction * kGravity;
  // The trunk turns so that the ZMP stays where it is.
  Kinematics kinematics(robot_);
  VecX force(robot_.nv());
  const auto zmp = [&] {
    kinematics.inverse_dynamics(sample.q, sample.dq, sample.ddq, force);
    return ground_wrench(kinematics, force).zmp(0.0);
  };
  const Vec2 wanted = motion.samples[0].zmp;
  for (int pass = 0; pass < 10; ++pass) {
    const Vec2 error = wanted - zmp();
    Eigen::Matrix2d slope;
    for (const int axis : {0, 1}) {
      sample.ddq[3 + axis] += 1.0;
      slope.col(axis) = zmp() - (wanted - error);
      sample.ddq[3 + axis] -= 1.0;
    }
    sample.ddq.segment<2>(3) += slope.inverse() * error;
  }
  ASSERT_LT((zmp() - wanted).norm(), 1e-6);
  const double expected = force.head<2>().norm() / force[2];
  ASSERT_GT(expected, margin_.friction);
  const Refusal refusal = refusal_of(motion);
  EXPECT_EQ(refusal.reason, Reason::friction) << to_string(refusal.reason);
  EXPECT_NEAR(refusal.value, expected, 1e-12);
  EXPECT_EQ(refusal.limit, margin_.friction);
}

TEST_P(VerifierTest, RefusesSolesThatPassTooClosely) {
  Motion motion = step();
  MotionSample& sample = motion.samples[middle_of_the_swing(motion)];
  const Side swing = *motion.goal.swing;
  const double gap = 0.5 * robot_.profile().region.sole_gap;
  double half_width = 0.0;
  for (const Vec2& vertex : robot_.sole(swing).vertices())
    half_width = std::max(half_width, vertex.y());
  const Pose beside{Vec3(0.0, sign_of(swing) * (2.0 * half_width + gap), 0.1 * size_), Mat3::Identity()};
  sample.sole[swing] = sample.sole[other(swing)] * beside;
  const Refusal refusal = refusal_of(motion);
  EXPECT_EQ(refusal.reason, Reason::sole_gap) << to_string(refusal.reason);
  EXPECT_EQ(refusal.part, foot(swing));
  EXPECT_NEAR(refusal.value, gap, 1e-9);
  EXPECT_EQ(refusal.limit, robot_.profile().region.sole_gap);
}

TEST_P(VerifierTest, RefusesASwingThroughTheGround) {
  Motion motion = step();
  const Side swing = *motion.goal.swing;
  motion.samples[middle_of_the_swing(motion)].sole[swing].p.z() = -0.002;
  const Refusal refusal = refusal_of(motion);
  EXPECT_EQ(refusal.reason, Reason::swing_ground) << to_string(refusal.reason);
  EXPECT_EQ(refusal.part, foot(swing));
  EXPECT_NEAR(refusal.value, -0.002, 1e-12);
  EXPECT_LT(refusal.value, refusal.limit);
}

TEST_P(VerifierTest, AFootThatStandsALittleLowerThanTheMapSaysMayLeave) {
  Verifier verifier(robot_, world_);
  const double flatness = robot_.profile().ground.flatness;
  for (double share = -0.9; share < 1.0; share += 0.1) {  // of what a foothold may be off
    Motion motion = step();
    const auto verdict = verifier.verify(motion, {Vec3(0, 0, share * flatness), Mat3::Identity()}, limits_);
    EXPECT_TRUE(std::holds_alternative<VerifiedMotion>(verdict)) << share;
  }
  Motion motion = step();
  const auto verdict = verifier.verify(motion, {Vec3(0, 0, -1.5 * flatness), Mat3::Identity()}, limits_);
  EXPECT_TRUE(std::holds_alternative<Refusal>(verdict)) << "but not from below it";
}

TEST_P(VerifierTest, RefusesAnArmInTheTrunk) {
  const RobotModel anywhere = untracked();
  Verifier verifier(anywhere, world_);
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Kinematics kinematics(robot_);
  int tried = 0;
  for (int trial = 0; trial < 2000 && tried < 20; ++trial) {
    Motion motion = step();
    MotionSample& sample = motion.samples[4];
    for (const int j : robot_.arm(Side::left)) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
      const double lo = joint.position.lo + margin_.joint;
      sample.q[7 + j] = lo + uniform(random) * (joint.position.hi - margin_.joint - lo);
    }
    kinematics.set(sample.q);
    std::array<int, 2> pair{-1, -1};
    const double distance = kinematics.self_distance(0.05 * size_, &pair);
    if (distance >= 0.9 * margin_.self_collision) continue;
    ++tried;
    const Refusal refusal = refusal_of(motion, verifier);
    EXPECT_EQ(refusal.reason, Reason::self_collision) << to_string(refusal.reason);
    EXPECT_NEAR(refusal.value, distance, 1e-9);
    EXPECT_EQ(refusal.limit, margin_.self_collision);
    const std::string one = name_of(robot_.mj(), mjOBJ_GEOM, pair[0]);
    const std::string two = name_of(robot_.mj(), mjOBJ_GEOM, pair[1]);
    EXPECT_THAT(refusal.where, testing::AllOf(testing::HasSubstr(one), testing::HasSubstr(two)));
  }
  EXPECT_EQ(tried, 20);
}

/// A floor with one box that is in the way.
World floor_with_box(const std::string& name, const Vec3& centre, double half) {
  const auto file = std::filesystem::path(test::temp_folder()) / ("baton_box_" + name + ".xml");
  std::ofstream(file) << "<mujoco model=\"box\"><worldbody>\n"
                      << "<geom name=\"ground\" type=\"plane\" size=\"0 0 0.05\"/>\n"
                      << "<site name=\"start\" pos=\"0 0 0\"/>\n"
                      << "<geom name=\"crate\" type=\"box\" pos=\"" << centre.transpose() << "\" size=\"" << half << " "
                      << half << " " << half << "\"/></worldbody></mujoco>\n";
  return World(file);
}

TEST_P(VerifierTest, FromTooNearAThingItMayLeaveButNotComeNearer) {
  const Motion motion = step();
  Kinematics kinematics(robot_);
  kinematics.set(motion.samples.front().q);
  const Vec3 hand_before = kinematics.hand(Side::left).p;
  kinematics.set(motion.samples.back().q);
  const Vec3 way = kinematics.hand(Side::left).p - hand_before;
  const double half = 0.02 * size_;
  for (const double direction : {1.0, -1.0}) {
    // A crate beside the hand, moved until it is half the margin away: ahead of it or behind it.
    double gap = 0.02 * size_;
    double distance = 0.0;
    std::optional<World> world;
    for (int k = 0; k < 60; ++k) {
      const double side = direction * (way.x() > 0.0 ? 1.0 : -1.0);
      world.emplace(floor_with_box(GetParam(), hand_before + Vec3(side * (half + gap), 0, 0), half));
      std::array<int, 2> pair{-1, -1};
      Obstacles obstacles(robot_, *world);
      obstacles.set(motion.samples.front().q);
      distance = obstacles.distance(false, 1.0, pair);
      if (std::abs(distance - 0.5 * margin_.self_collision) < 1e-5) break;
      gap += 0.5 * margin_.self_collision - distance;
    }
    ASSERT_NEAR(distance, 0.5 * margin_.self_collision, 1e-5);
    Verifier verifier(robot_, *world);
    Motion moves = motion;
    const auto verdict = verifier.verify(moves, Pose{}, limits_);
    ASSERT_EQ(std::holds_alternative<VerifiedMotion>(verdict), direction < 0.0);
    if (const auto* refusal = std::get_if<Refusal>(&verdict)) {
      EXPECT_EQ(refusal->reason, Reason::obstacle);
    }
  }
}

TEST_P(VerifierTest, RefusesABodyThatHitsAThingInTheWorld) {
  const Motion motion = step();
  Kinematics kinematics(robot_);
  const double half = 0.02 * size_;
  // In the plan's frame and, the same for the robot, in a world that is turned.
  for (const Pose& anchor : {Pose{}, Pose{Vec3(0.4, 0.2, 0), rotation_z(0.5)}}) {
    kinematics.set(motion.samples[4].q);
    const Vec3 hand = anchor * kinematics.hand(Side::left).p;
    const World in_the_way = floor_with_box(GetParam(), hand, half);
    Verifier verifier(robot_, in_the_way);
    Motion hits = motion;
    const auto verdict = verifier.verify(hits, anchor, limits_);
    ASSERT_TRUE(std::holds_alternative<Refusal>(verdict));
    const auto& refusal = std::get<Refusal>(verdict);
    EXPECT_EQ(refusal.reason, Reason::obstacle) << to_string(refusal.reason);
    EXPECT_LT(refusal.value, margin_.self_collision);
    EXPECT_EQ(refusal.limit, margin_.self_collision);
    EXPECT_THAT(refusal.where, testing::HasSubstr("crate"));

    const World beside = floor_with_box(GetParam(), anchor * Vec3(0, 10 * size_, size_), half);
    Verifier free(robot_, beside);
    EXPECT_FALSE(certificate_of(motion, free, limits_, anchor).margins.empty());
  }
}

TEST_P(VerifierTest, TheLessSureThePlaceTheFartherFromThingsTrunkAndLegsStay) {
  Motion motion = step();
  const double half = 0.02 * size_;
  const double to_spare = 0.05 * size_;
  const auto least_distance = [&](const World& world, bool by_map) {
    Obstacles obstacles(robot_, world);
    double least = std::numeric_limits<double>::infinity();
    for (const MotionSample& sample : motion.samples) {
      std::array<int, 2> pair{-1, -1};
      obstacles.set(sample.q);
      least = std::min(least, obstacles.distance(by_map, 10.0 * size_, pair));
    }
    return least;
  };
  // A crate ahead of the trunk, moved until it is that far beyond the margin.
  double x = motion.samples.front().com.x() + 0.6 * size_;
  std::optional<World> world;
  for (int k = 0; k < 60; ++k) {
    world.emplace(floor_with_box(GetParam(), Vec3(x, 0, size_), half));
    const double off = margin_.self_collision + to_spare - least_distance(*world, true);
    if (std::abs(off) < 1e-5) break;
    x += off;
  }
  ASSERT_NEAR(least_distance(*world, true), margin_.self_collision + to_spare, 1e-5);
  ASSERT_GT(least_distance(*world, false), margin_.self_collision);
  Verifier verifier(robot_, *world);
  for (const double unsure : {0.0, 0.03, 0.049, 0.051, 0.08, 0.2}) {
    motion.goal.place_uncertainty = unsure * size_;
    const auto verdict = verifier.verify(motion, Pose{}, limits_);
    ASSERT_EQ(std::holds_alternative<VerifiedMotion>(verdict), unsure < 0.05) << unsure;
    if (unsure < 0.05) continue;
    EXPECT_EQ(std::get<Refusal>(verdict).reason, Reason::obstacle);
    EXPECT_THAT(std::get<Refusal>(verdict).where, testing::HasSubstr("crate"));
  }
}

TEST_P(VerifierTest, TheArmsDistanceIsTheOperatorsMatter) {
  Motion motion = step();
  Kinematics kinematics(robot_);
  kinematics.set(motion.samples.front().q);
  const double half = 0.02 * size_;
  const World beside =
      floor_with_box(GetParam(), kinematics.hand(Side::left).p + Vec3(0, half + 0.16 * size_, 0), half);
  Obstacles obstacles(robot_, beside);
  double arms = std::numeric_limits<double>::infinity();
  double others = arms;
  for (const MotionSample& sample : motion.samples) {
    std::array<int, 2> pair{-1, -1};
    obstacles.set(sample.q);
    arms = std::min(arms, obstacles.distance(false, size_, pair) - margin_.self_collision);
    others = std::min(others, obstacles.distance(true, size_, pair) - margin_.self_collision);
  }
  ASSERT_GT(arms, 0.0);
  ASSERT_LT(arms, 0.09 * size_);
  ASSERT_GT(others, arms);
  motion.goal.place_uncertainty = 0.5 * (arms + std::min(others, 0.1 * size_));
  Verifier verifier(robot_, beside);
  EXPECT_FALSE(certificate_of(motion, verifier, limits_).margins.empty());
}

TEST_P(VerifierTest, MeasuresTheDistanceToAThing) {
  // A crate outside the left hand at known distances: the least distance appears in the certificate.
  const Motion& motion = *motions_.front();
  Kinematics kinematics(robot_);
  for (const double gap : {1.5, 2.0, 3.0}) {
    double outmost = -std::numeric_limits<double>::infinity();
    for (const MotionSample& sample : motion.samples) {
      kinematics.set(sample.q);
      for (int g = 0; g < robot_.mj().ngeom; ++g) {
        if (robot_.mj().geom_contype[g] == 0 && robot_.mj().geom_conaffinity[g] == 0) continue;
        const int body = robot_.mj().geom_bodyid[g];
        if (body == robot_.foot_body(Side::left) || body == robot_.foot_body(Side::right)) continue;
        const Pose link = kinematics.body(body);
        const double* quat = robot_.mj().geom_quat + 4 * g;
        const Mat3 R = link.R * Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix();
        const Vec3 centre = link * Vec3(Eigen::Map<const Vec3>(robot_.mj().geom_pos + 3 * g));
        const double* size = robot_.mj().geom_size + 3 * g;
        double reach = 0.0;  // of the geom along y
        if (robot_.mj().geom_type[g] == mjGEOM_BOX) {
          for (int axis = 0; axis < 3; ++axis)
            reach += size[axis] * std::abs(R(1, axis));
        } else {
          ASSERT_EQ(robot_.mj().geom_type[g], mjGEOM_CAPSULE);
          reach = size[0] + size[1] * std::abs(R(1, 2));
        }
        outmost = std::max(outmost, centre.y() + reach);
      }
    }
    const double half = 5.0 * size_;
    const double distance = gap * margin_.self_collision;
    const World wall = floor_with_box(GetParam(), Vec3(0, outmost + distance + half, 0), half);
    Verifier verifier(robot_, wall);
    const Certificate certificate = certificate_of(motion, verifier, limits_);
    bool found = false;
    for (const Margin& margin : certificate.margins) {
      if (margin.quantity != Reason::obstacle) continue;
      found = true;
      EXPECT_NEAR(margin.value, distance, 1e-5);
      EXPECT_THAT(margin.where, testing::HasSubstr("crate"));
    }
    EXPECT_TRUE(found);
  }
}

TEST_P(VerifierTest, RefusesWhatIsNotANumber) {
  std::mt19937_64 random(9);
  for (int trial = 0; trial < 300; ++trial) {
    Motion motion = step();
    MotionSample& sample = motion.samples[random() % motion.samples.size()];
    const double bad = trial % 2 == 0 ? kNaN : std::numeric_limits<double>::infinity();
    const auto nv = static_cast<std::size_t>(robot_.nv());
    const Side side = kSides[random() % 2];
    switch (trial % 7) {
      case 0:
        sample.q[static_cast<Eigen::Index>(random() % (nv + 1))] = bad;
        break;
      case 1:
        sample.dq[static_cast<Eigen::Index>(random() % nv)] = bad;
        break;
      case 2:
        sample.ddq[static_cast<Eigen::Index>(random() % nv)] = bad;
        break;
      case 3:
        sample.com[static_cast<Eigen::Index>(random() % 3)] = bad;
        break;
      case 4:
        sample.sole[side].p[static_cast<Eigen::Index>(random() % 3)] = bad;
        break;
      case 5:
        sample.sole[side].R(static_cast<Eigen::Index>(random() % 3), 1) = bad;
        break;
      default:
        sample.dcom[static_cast<Eigen::Index>(random() % 3)] = bad;
        break;
    }
    const Refusal refusal = refusal_of(motion);
    EXPECT_EQ(refusal.reason, Reason::not_finite) << "kind " << trial % 7 << ": " << to_string(refusal.reason);
  }
}

TEST_P(VerifierTest, EveryMarginIsWhereALimitWouldBegin) {
  // With a limit a little beyond the value that the certificate gives, the motion passes; a little short of
  // it, it is refused for that very reason, with that value.
  for (std::size_t i = 0; i < motions_.size(); i += 6) {
    const VerifiedMotion& motion = motions_[i];
    for (const Margin& margin : motion.certificate().margins) {
      for (const bool strict : {false, true}) {
        Profile profile = robot_.profile();
        Limits limits = limits_;
        const double tiny = (strict ? 1e-6 : -1e-6) * (1.0 + std::abs(margin.value));
        switch (margin.quantity) {
          case Reason::zmp:
            limits.zmp_verify = margin.value + tiny;
            break;
          case Reason::joint_limit:
            limits.joint = margin.value + tiny;
            break;
          case Reason::joint_acceleration:
            limits.acceleration = margin.value - tiny;
            break;
          case Reason::joint_torque:
            limits.torque = margin.value - tiny;
            break;
          case Reason::friction:
            limits.friction = margin.value - tiny;
            break;
          case Reason::sole_gap:
            profile.region.sole_gap = margin.value + tiny;
            break;
          default:
            continue;
        }
        const RobotModel other(profile);
        Verifier verifier(other, world_);
        if (margin.quantity == Reason::zmp || margin.quantity == Reason::friction) {
          // Forces at the vertices meet these limits too, and have less room.
          if (!strict) continue;
          const Reason reason = refusal_of(*motion, verifier, limits).reason;
          EXPECT_TRUE(reason == margin.quantity || reason == Reason::contact_wrench) << to_string(reason);
          continue;
        }
        if (!strict) {
          EXPECT_FALSE(certificate_of(*motion, verifier, limits).margins.empty()) << to_string(margin.quantity);
          continue;
        }
        const Refusal refusal = refusal_of(*motion, verifier, limits);
        EXPECT_EQ(refusal.reason, margin.quantity) << to_string(refusal.reason);
        EXPECT_NEAR(refusal.value, margin.value, 2e-6 * (1.0 + std::abs(margin.value)));
        EXPECT_EQ(refusal.where, margin.where);
      }
    }
  }
}

/// ZMP on the floor from the rate of momentum of the whole body, by differences of the kinematics along the
/// parabola that q, q̇ and q̈ give. Nothing of inverse dynamics is used.
Vec2 zmp_by_momentum(const RobotModel& robot, const MotionSample& sample) {
  const mjModel& m = robot.mj();
  const DataPtr data(mj_makeData(&m));
  const double h = 1e-5;
  const auto momentum = [&](double t) {
    VecX q = sample.q;
    integrate(robot, q, sample.dq + 0.5 * t * sample.ddq, t);
    const VecX dq = sample.dq + t * sample.ddq;
    mju_copy(data->qpos, q.data(), m.nq);
    mju_copy(data->qvel, dq.data(), m.nv);
    mj_kinematics(&m, data.get());
    mj_comPos(&m, data.get());
    mj_comVel(&m, data.get());
    mj_subtreeVel(&m, data.get());
    Vec6 values;
    values.head<3>() = robot.mass() * Eigen::Map<const Vec3>(data->subtree_linvel);
    values.tail<3>() = Eigen::Map<const Vec3>(data->subtree_angmom);  // about the COM
    return values;
  };
  const Vec6 rate = (momentum(h) - momentum(-h)) / (2.0 * h);
  static_cast<void>(momentum(0.0));
  const Vec3 com = Eigen::Map<const Vec3>(data->subtree_com);
  const Vec3 force = rate.head<3>() + Vec3(0, 0, robot.mass() * kGravity);
  const Vec3 moment = com.cross(force) + rate.tail<3>();
  return {-moment.y() / force.z(), moment.x() / force.z()};
}

TEST_P(VerifierTest, TheZmpIsThatOfTheMomentum) {
  int checked = 0;
  for (const VerifiedMotion& verified : motions_) {
    const Motion& motion = *verified;
    // The soles lie on the floor: the support polygon is the hull of their corners.
    double worst = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < motion.samples.size(); ++k) {
      const MotionSample& sample = motion.samples[k];
      const Vec2 zmp = zmp_by_momentum(robot_, sample);
      ASSERT_LT((zmp - sample.zmp).norm(), 1e-5 * size_) << "tick " << k;
      std::vector<Vec2> corners;
      for (const Side side : kSides) {
        bool stands = true;
        for (const std::size_t near : {k > 0 ? k - 1 : k, k}) {
          stands = stands && motion.samples[near].contact[side];
        }
        if (!stands) continue;
        ASSERT_NEAR(sample.sole[side].p.z(), 0.0, 1e-6);
        for (const Vec2& vertex : robot_.sole(side).vertices()) {
          corners.push_back((sample.sole[side] * Vec3(vertex.x(), vertex.y(), 0)).head<2>());
        }
      }
      worst = std::min(worst, ConvexPolygon::hull(corners).margin(zmp));
      ++checked;
    }
    for (const Margin& margin : verified.certificate().margins) {
      if (margin.quantity != Reason::zmp) continue;
      EXPECT_NEAR(margin.value, worst, 2e-5 * size_);
    }
    EXPECT_GE(worst, margin_.zmp_verify - 2e-5 * size_);
  }
  EXPECT_GT(checked, 2000);
}

TEST_P(VerifierTest, TheTorqueIsThatOfInverseDynamicsInTheWholeModel) {
  // mj_inverse on robot and world in one model, without constraints; the wrench then goes through the soles.
  const ModelPtr model = compile_text(world_.compose(robot_, 0.001), "test");
  model->opt.disableflags |= mjDSBL_CONSTRAINT;
  const DataPtr data(mj_makeData(model.get()));
  ASSERT_EQ(model->nv, robot_.nv());
  Kinematics kinematics(robot_);
  JacobianRows jacobian(6, robot_.nv());
  for (std::size_t i = 0; i < motions_.size(); i += 2) {
    const Motion& motion = *motions_[i];
    double worst = 0.0;
    for (const MotionSample& sample : motion.samples) {
      mju_copy(data->qpos, sample.q.data(), model->nq);
      mju_copy(data->qvel, sample.dq.data(), model->nv);
      mju_copy(data->qacc, sample.ddq.data(), model->nv);
      mj_inverse(model.get(), data.get());
      VecX tau = Eigen::Map<const VecX>(data->qfrc_inverse, model->nv);
      tau += Eigen::Map<const VecX>(data->qfrc_passive, model->nv);  // without the motors' damping
      kinematics.set(sample.q);
      const auto shared = share_wrench(robot_, sample.sole, sample.contact, ground_wrench(kinematics, tau));
      for (const Side side : kSides) {
        kinematics.point_jacobian(robot_.foot_body(side), Vec3::Zero(), jacobian.topRows(3));
        kinematics.rotation_jacobian(robot_.foot_body(side), jacobian.bottomRows(3));
        Vec6 wrench;
        wrench << shared[side].force, shared[side].moment;
        tau -= jacobian.transpose() * wrench;
      }
      ASSERT_LT(tau.head<6>().norm(),
                1e-8 * robot_.mass() * kGravity);  // nothing is left for the trunk to bear
      for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
        const auto dof = static_cast<Eigen::Index>(6 + j);
        const Motor& motor = robot_.joints()[j].motor;
        worst = std::max(worst, (std::abs(tau[dof]) + motor.damping * std::abs(sample.dq[dof])) / motor.stall);
      }
    }
    for (const Margin& margin : motions_[i].certificate().margins) {
      if (margin.quantity != Reason::joint_torque) continue;
      EXPECT_NEAR(margin.value, worst, 1e-6);
    }
    EXPECT_LE(worst, margin_.torque);
  }
}

}  // namespace
}  // namespace baton
