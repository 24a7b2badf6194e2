#include "baton/balance/footing.hpp"

#include <gtest/gtest.h>

#include "baton/proving/scenario.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/random.hpp"
#include "tests/verify/sample_motions.hpp"

namespace baton {
namespace {

using test::Random;

// Bounds of an offset; lengths are shares of the COM height.
constexpr double kMostHeight = 0.05;
constexpr double kMostPlace = 0.1;
constexpr double kMostTurn = 0.2;  // [rad]
// What need not be followed: less is as planned.
constexpr double kExact = 6e-4;
constexpr double kLevel = 1.5e-3;  // [rad]

class FootingTest : public testing::TestWithParam<std::string> {
 protected:
  /// Samples of motions, as they are planned.
  const std::vector<MotionSample>& samples() {
    static std::map<std::string, std::vector<MotionSample>> known;
    std::vector<MotionSample>& list = known[GetParam()];
    if (!list.empty()) return list;
    for (const VerifiedMotion& verified : test::sample_motions(GetParam())) {
      const Motion& motion = *verified;
      for (std::size_t k = 0; k < motion.samples.size(); k += 7)
        list.push_back(motion.samples[k]);
    }
    return list;
  }

  /// What each sole should carry by a plan.
  [[nodiscard]] BySide<Wrench> wanted_by(const MotionSample& sample) {
    kinematics_.set(sample.q);
    const BySide<Wrench> shared =
        share_wrench(robot_, sample.sole, sample.contact, ground_wrench(kinematics_, sample.force));
    BySide<Wrench> wanted;
    for (const Side side : kSides)
      wanted[side] = {shared[side].force, shared[side].moment_about(sample.sole[side].p)};
    return wanted;
  }

  /// A share of the weight, in the middle of the sole.
  [[nodiscard]] Wrench load(double share) const { return {Vec3(0, 0, share * weight_), Vec3::Zero()}; }

  /// A load that presses at a point of a sole, given in the sole's frame.
  [[nodiscard]] Wrench load_at(double share, const Pose& sole, const Vec2& point) const {
    const Vec3 force(0, 0, share * weight_);
    return {force, (sole.R * Vec3(point.x(), point.y(), 0)).cross(force)};
  }

  /// The state of a robot that is just where the plan says, with these forces under its soles.
  [[nodiscard]] State as_planned(const MotionSample& sample, const BySide<Wrench>& force) const {
    State state;
    state.q = sample.q;
    state.com = sample.com;
    state.dcom = sample.dcom;
    state.sole = sample.sole;
    state.force = force;
    return state;
  }

  static bool nothing(const Footing::Offset& offset) { return offset.p.isZero(0.0) && offset.turn.isZero(0.0); }
  /// Length and angle together.
  [[nodiscard]] double size_of(const Footing::Offset& offset) const {
    return offset.p.norm() / size_ + offset.turn.norm();
  }

  [[nodiscard]] static Pose displaced(const Pose& sole, const Footing::Offset& by) {
    return {sole.p + by.p, rotation_exp(by.turn) * sole.R};
  }
  /// A few mm to any side, and inclined.
  [[nodiscard]] Footing::Offset some_offset() { return {random_.vector(0.015 * size_), random_.horizontal(0.05)}; }

  /// Of a leg, from its first to its last joint [m].
  [[nodiscard]] double length_of(Side side, const Kinematics& at) const {
    const std::vector<int>& leg = robot_.leg(side);
    return (at.dof_axis(6 + leg.back()).point - at.dof_axis(6 + leg.front()).point).norm();
  }
  [[nodiscard]] BySide<double> longest() {
    VecX q = held_.q;
    for (const Side side : kSides) {
      for (const int j : robot_.leg(side)) {
        const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
        q[7 + j] = std::clamp(0.0, range.lo, range.hi);
      }
    }
    kinematics_.set(q);
    return {length_of(Side::left, kinematics_), length_of(Side::right, kinematics_)};
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const RobotModel stiff_ = with_drive(robot_, Drive::stiff);
  const double size_ = robot_.profile().stance.com_height;
  const double weight_ = robot_.mass() * kGravity;
  const int n_ = robot_.nv() - 6;
  const int second_ = static_cast<int>(std::lround(1.0 / robot_.profile().tick.period));  ///< ticks
  const MotionSample held_ = resting(robot_, stand(robot_, Pose{}, size_));
  const BySide<Wrench> halves_{load(0.5), load(0.5)};
  Kinematics kinematics_{robot_};
  const BySide<double> longest_ = longest();  ///< with straight legs
  Random random_{8};
};

INSTANTIATE_TEST_SUITE_P(Robots, FootingTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(FootingTest, WhereEverythingIsAsPlannedNothingIsAdded) {
  ASSERT_GT(samples().size(), 200u);
  for (const RobotModel* robot : {&robot_, &stiff_}) {
    Footing footing(*robot);
    for (const MotionSample& sample : samples()) {
      const BySide<Wrench> wanted = wanted_by(sample);
      footing.follow(sample, sample, as_planned(sample, wanted), wanted);
      for (const Side side : kSides)
        ASSERT_TRUE(nothing(footing.offset()[side]));
      VecX q;
      kinematics_.set(sample.q);
      footing.apply(kinematics_, sample.q, q);
      ASSERT_EQ(q, sample.q.tail(n_));
    }
  }
}

TEST_P(FootingTest, SolesThatStandElsewhereAreFollowedThere) {
  for (int trial = 0; trial < 100; ++trial) {
    const BySide<Footing::Offset> away{some_offset(), some_offset()};
    MotionSample now = held_;
    const double left = random_(0.35, 0.65);
    const BySide<Wrench> wanted{load(left), load(1.0 - left)};
    State state = as_planned(now, wanted);
    for (const Side side : kSides)
      state.sole[side] = displaced(now.sole[side], away[side]);
    MotionSample next = now;
    if (random_.coin()) {  // it stands sooner than planned, on its way down
      const Side early = trial % 2 == 0 ? Side::left : Side::right;
      now.contact[early] = next.contact[early] = false;
      next.sole[early].p.z() -= 1e-3 * size_;
    }
    Footing footing(robot_);
    BySide<double> off{size_of(away.left), size_of(away.right)};
    for (int tick = 0; tick < 3 * second_; ++tick) {
      footing.follow(now, next, state, wanted);
      for (const Side side : kSides) {
        const Footing::Offset& offset = footing.offset()[side];
        const double still = size_of({away[side].p - offset.p, away[side].turn - offset.turn});
        ASSERT_LE(still, off[side] + 1e-12) << "nearer at every tick";
        off[side] = still;
      }
    }
    for (const Side side : kSides) {
      const Footing::Offset& offset = footing.offset()[side];
      ASSERT_LT((offset.p - away[side].p).norm(), kExact * size_) << "trial " << trial;
      ASSERT_LT((offset.turn - away[side].turn).norm(), kLevel) << "trial " << trial;
    }
  }
}

TEST_P(FootingTest, AFootThatShouldCarryLooksForTheGroundFartherDown) {
  for (int trial = 0; trial < 20; ++trial) {
    const double planned = random_(0.0, 1.0);
    const BySide<Wrench> wanted{load(planned), load(1.0 - planned)};
    Footing footing(robot_);
    Footing senseless(robot_);
    double before = 0.0;
    for (int tick = 0; tick < second_; ++tick) {
      footing.follow(held_, held_, as_planned(held_, {Wrench{}, load(1.0)}), wanted);
      const double z = footing.offset().left.p.z();
      ASSERT_LE(z, before);
      ASSERT_GE(z, -kMostHeight * size_);
      before = z;
      senseless.follow(held_, held_, as_planned(held_, {Wrench{}, Wrench{}}), wanted);
      ASSERT_TRUE(nothing(senseless.offset().left)) << "no sole is known to carry";
    }
    EXPECT_EQ(before<-0.03 * size_, planned> 0.1) << planned;
    if (planned < 0.1) continue;
    for (const double excess : {0.0, 0.05}) {  // it has found it, 2 mm below, and presses as it should, or by more
      Footing landed = footing;
      State found = as_planned(held_, {load(planned + excess), load(1.0 - planned - excess)});
      found.sole.left.p.z() -= 0.008 * size_;
      for (int tick = 0; tick < second_; ++tick) {
        const double z = landed.offset().left.p.z();
        landed.follow(held_, held_, found, wanted);
        ASSERT_LT(std::abs(landed.offset().left.p.z() - z), 0.012 * size_) << "no jump";
        // A robot fell over its other foot as this one pressed on by what it had reached too far.
        if (excess == 0.0 || tick < 5) continue;
        ASSERT_NEAR(landed.offset().left.p.z(), -0.008 * size_, 1.5e-3 * size_);
      }
      EXPECT_NEAR(landed.offset().left.p.z(), -0.008 * size_, kExact * size_);
    }
  }
}

TEST_P(FootingTest, TheLegsTakeTheSolesThere) {
  const double margin = robot_.profile().margin.joint;
  Kinematics moved(robot_);
  int compared = 0;
  int straight = 0;
  for (int trial = 0; trial < 20; ++trial) {
    State state = as_planned(held_, halves_);
    for (const Side side : kSides)
      state.sole[side] = displaced(held_.sole[side], some_offset());
    Footing footing(robot_);
    for (int tick = 0; tick < 2 * second_; ++tick)
      footing.follow(held_, held_, state, halves_);
    for (std::size_t k = static_cast<std::size_t>(trial); k < samples().size(); k += 10) {
      MotionSample sample = samples()[k];
      if (k % 3 == 0) {  // or with legs that are nearly straight
        for (const Side side : kSides) {
          for (const int j : robot_.leg(side)) {
            const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
            sample.q[7 + j] = std::clamp(random_(-0.15, 0.15), range.lo + 0.02, range.hi - 0.02);
          }
        }
      }
      VecX q;
      for (int tick = 0; tick < 10; ++tick) {  // as it goes on from there, it may take some to get there
        kinematics_.set(sample.q);
        footing.apply(kinematics_, sample.q, q);
      }
      kinematics_.set(sample.q);
      VecX with = sample.q;  // the root stays
      with.tail(n_) = q;
      moved.set(with);
      VecX others = q - sample.q.tail(n_);
      bool at_limit = false;
      BySide<double> down;
      BySide<double> stretched;
      for (const Side side : kSides) {
        for (const int j : robot_.leg(side)) {
          const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
          at_limit = at_limit || q[j] < range.lo + margin + 1e-9 || q[j] > range.hi - margin - 1e-9;
          others[j] = 0.0;
        }
        const Pose goal = displaced(kinematics_.sole(side), footing.offset()[side]);
        const Pose sole = moved.sole(side);
        down[side] = sole.p.z() - goal.p.z();
        stretched[side] = length_of(side, moved) - length_of(side, kinematics_);
        if (at_limit) continue;
        ASSERT_LT((sole.p - goal.p).head<2>().norm(), 1e-4 * size_);
        ASSERT_LT(rotation_error(goal.R, sole.R).norm(), 1e-4);
      }
      ASSERT_TRUE(others.isZero(0.0)) << "a joint that is none of the legs'";
      if (at_limit) continue;
      ++compared;
      // The trunk comes down as far as it must for no leg to be stretched, and no farther.
      EXPECT_NEAR(down.left, down.right, 2e-4 * size_);
      EXPECT_GT(down.left, -1e-4 * size_);
      const double most = std::max(stretched.left, stretched.right);
      EXPECT_LT(most, 1e-4 * size_);
      if (down.left > 1e-3 * size_) {
        EXPECT_GT(most, -1e-4 * size_);
      }
      for (const Side side : kSides)
        straight += length_of(side, kinematics_) > 0.995 * longest_[side] ? 1 : 0;
    }
  }
  EXPECT_GT(compared, 400);
  EXPECT_GT(straight, 10) << "where a single step of Newton's method is far off";
}

TEST_P(FootingTest, WhateverIsMeasuredItIsBounded) {
  for (int trial = 0; trial < 300; ++trial) {
    Footing footing(trial % 3 == 0 ? stiff_ : robot_);
    for (int tick = 0; tick < 10; ++tick) {
      MotionSample now = samples()[random_.below(samples().size())];
      State state = as_planned(now, {});
      BySide<Wrench> wanted;
      for (const Side side : kSides) {
        state.sole[side] = {random_.coin() ? random_.wild_vector() : random_.vector(size_),
                            rotation_exp(random_.vector(2.0))};
        state.force[side] = {random_.wild_vector(), random_.wild_vector()};
        if (random_.coin()) state.force[side] = {random_.vector(2.0 * weight_), random_.vector(size_ * weight_)};
        wanted[side] = {random_.wild_vector(), random_.wild_vector()};
        now.contact[side] = random_.coin();
      }
      MotionSample next = now;
      for (const Side side : kSides)
        next.sole[side].p += random_.vector(0.01 * size_);
      footing.follow(now, next, state, wanted);
      for (const Side side : kSides) {
        const Footing::Offset& offset = footing.offset()[side];
        ASSERT_TRUE(offset.p.allFinite() && offset.turn.allFinite());
        ASSERT_LE(std::abs(offset.p.z()), kMostHeight * size_);
        ASSERT_LE(offset.p.head<2>().norm(), kMostPlace * size_ * (1.0 + 1e-12));
        ASSERT_LE(offset.turn.norm(), kMostTurn * (1.0 + 1e-12));
      }
      kinematics_.set(now.q);
      VecX q;
      footing.apply(kinematics_, now.q, q);
      for (int j = 0; j < n_; ++j) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
        ASSERT_GE(q[j], joint.position.lo) << joint.name;
        ASSERT_LE(q[j], joint.position.hi) << joint.name;
      }
    }
  }
}

TEST_P(FootingTest, ASoleYieldsToTheMomentThatIsTooMuch) {
  for (int trial = 0; trial < 200; ++trial) {
    const Side side = random_.coin() ? Side::left : Side::right;
    const Vec3 way = random_.direction();
    const auto after = [&](const RobotModel& robot, double excess, int ticks) {
      BySide<Wrench> force = halves_;
      force[side].moment += excess * 0.5 * weight_ * size_ * way;
      Footing footing(robot);
      for (int tick = 0; tick < ticks; ++tick)
        footing.follow(held_, held_, as_planned(held_, force), halves_);
      EXPECT_TRUE(nothing(footing.offset()[other(side)]));
      EXPECT_TRUE(footing.offset()[side].p.isZero(0.0));
      return footing.offset()[side].turn;
    };
    // Within the dead band nothing happens, however long.
    ASSERT_TRUE(after(robot_, random_(0.0, 0.03), second_).isZero(0.0));
    for (const RobotModel* robot : {&robot_, &stiff_}) {
      const double excess = random_(0.06, 0.15);
      const Vec3 turn = after(*robot, excess, 10);
      ASSERT_GT(turn.dot(way), 0.0);
      ASSERT_EQ(turn.norm() < after(robot_, excess, 10).norm(), robot == &stiff_) << "a stiff robot less far";
      ASSERT_LT(turn.cross(way).norm(), 1e-9 * turn.norm());
      ASSERT_GT(after(*robot, 1.5 * excess, 10).norm(), turn.norm()) << "more, the more there is";
      // It gives way: where the sole is pressed at goes up.
      const Vec3 pressed = Vec3(0, 0, 1).cross(way);
      ASSERT_GT((rotation_exp(turn) * pressed).z(), 0.0);
    }
  }
}

TEST_P(FootingTest, ASoleThatTipsOnAnEdgeYieldsFasterTheLongerItLasts) {
  for (int trial = 0; trial < 200; ++trial) {
    const Side side = random_.coin() ? Side::left : Side::right;
    const Vec3 way = random_.direction();
    const double excess = random_(0.06, 0.15);
    // Turned by in each of 40 ticks, with a moment whose sense changes at times.
    const auto turns = [&](int changes_after) {
      Footing footing(robot_);
      std::vector<double> list;
      double before = 0.0;
      for (int tick = 0; tick < 40; ++tick) {
        BySide<Wrench> force = halves_;
        force[side].moment += (tick / changes_after % 2 == 0 ? 0.5 : -0.5) * excess * weight_ * size_ * way;
        State state = as_planned(held_, force);
        state.sole[side] = displaced(state.sole[side], footing.offset()[side]);  // it does as it is told
        footing.follow(held_, held_, state, halves_);
        const double now = footing.offset()[side].turn.dot(way);
        list.push_back(std::abs(now - before));
        before = now;
        if (now > 0.5 * kMostTurn) break;
      }
      return list;
    };
    const std::vector<double> lasting = turns(1000);
    ASSERT_GT(lasting.back(), 1.8 * lasting.front());
    ASSERT_LT(lasting.back(), 4.1 * lasting.front());
    // What sways is not answered faster: targets come late, and it would grow.
    const std::vector<double> swaying = turns(5);
    for (const double turn : swaying)
      ASSERT_LT(turn, 1.3 * swaying.front());
  }
}

TEST_P(FootingTest, ASoleYieldsToTheForceThatIsTooMuch) {
  for (int trial = 0; trial < 200; ++trial) {
    const Side side = random_.coin() ? Side::left : Side::right;
    const auto after = [&](const RobotModel& robot, double excess, int ticks) {
      BySide<Wrench> force = halves_;
      force[side].force.z() += excess * weight_;
      Footing footing(robot);
      for (int tick = 0; tick < ticks; ++tick)
        footing.follow(held_, held_, as_planned(held_, force), halves_);
      const Footing::Offset& offset = footing.offset()[side];
      EXPECT_TRUE(nothing(footing.offset()[other(side)]));
      EXPECT_TRUE(offset.p.head<2>().isZero(0.0) && offset.turn.isZero(0.0));
      return offset.p.z();
    };
    ASSERT_EQ(after(robot_, random_(-0.08, 0.08), second_), 0.0);
    for (const RobotModel* robot : {&robot_, &stiff_}) {
      const double excess = random_(0.15, 0.4);
      const double up = after(*robot, excess, 10);
      ASSERT_GT(up, 0.0) << "up, out of the way";
      ASSERT_EQ(up < after(robot_, excess, 10), robot == &stiff_) << "a stiff robot less far";
      ASSERT_LT(after(*robot, -excess, 10), 0.0) << "down, to where the ground is";
    }
  }
}

TEST_P(FootingTest, TheMoreLoadRocksFromSoleToSoleTheLessASoleYields) {
  // Compliance with delay is what keeps a robot rocking. Soft ground has to be yielded to all the same.
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 way = random_.direction();
    const double rate = random_(6.0, 12.0);  // [Hz]
    const auto after = [&](double swing, double softness) {
      Footing footing(robot_);
      for (int tick = 0; tick < 20 * second_; ++tick) {
        const double t = static_cast<double>(tick) / second_;
        BySide<Wrench> wanted = halves_;
        const Vec3 moment = 0.03 * std::sin(0.3 + 8.0 * t) * way;
        wanted.left.moment += moment * weight_ * size_;
        State state = as_planned(held_, wanted);
        state.sole.left.R = rotation_exp(-softness * moment) * state.sole.left.R;
        for (const Side side : kSides)
          state.force[side].force.z() += sign_of(side) * 0.5 * swing * weight_ * std::sin(2.0 * M_PI * rate * t);
        footing.follow(held_, held_, state, wanted);
      }
      const Vec3 before = footing.offset().left.turn;
      BySide<Wrench> force = halves_;
      force.left.moment += 0.06 * weight_ * size_ * way;
      for (int tick = 0; tick < 4; ++tick)
        footing.follow(held_, held_, as_planned(held_, force), halves_);
      return (footing.offset().left.turn - before).dot(way);
    };
    const double calm = after(0.0, 0.0);
    EXPECT_GT(after(0.1, 0.0), 0.9 * calm) << "a tenth of the weight changes nothing";
    EXPECT_LT(after(0.5, 0.0), 0.2 * calm);
    EXPECT_LT(after(0.8, 0.0), 0.1 * calm);
    EXPECT_GT(after(0.5, 1.0), 0.5 * after(0.0, 1.0)) << "on soft ground";
  }
}

TEST_P(FootingTest, LegsThatPressAgainstEachOtherGiveWay) {
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 apart = random_(0.01, 0.2) * weight_ * random_.direction();
    const Vec3 twist = random_(-0.05, 0.05) * weight_ * size_ * Vec3::UnitZ();
    const Vec3 common = 0.1 * weight_ * random_.direction();  // what the robot is moved by, both soles alike
    const auto after = [&](const RobotModel& robot, double share) {
      BySide<Wrench> force = halves_;
      for (const Side side : kSides) {
        force[side].force += sign_of(side) * share * apart + common;
        force[side].moment += sign_of(side) * share * twist;
      }
      Footing footing(robot);
      for (int tick = 0; tick < 10; ++tick)
        footing.follow(held_, held_, as_planned(held_, force), halves_);
      return footing.offset();
    };
    const BySide<Footing::Offset> offset = after(robot_, 1.0);
    EXPECT_GT(offset.left.p.dot(apart), 0.0) << "to where it is pressed";
    EXPECT_LT(offset.left.p.cross(apart).norm(), 1e-9 * offset.left.p.norm() * apart.norm());
    EXPECT_GT(offset.left.turn.dot(twist), 0.0);
    EXPECT_LT((offset.left.p + offset.right.p).norm(), 1e-12 * size_) << "the other one as far the other way";
    EXPECT_LT((offset.left.turn + offset.right.turn).norm(), 1e-12);
    EXPECT_GT(after(robot_, 1.5).left.p.norm(), offset.left.p.norm()) << "more, the more there is";
    EXPECT_TRUE(nothing(after(robot_, 0.0).left)) << "what moves the whole robot is not theirs";
    const Footing::Offset stiff = after(stiff_, 1.0).left;
    EXPECT_LT(stiff.p.norm(), offset.left.p.norm()) << "stiff servos turn a small way into much force";
    EXPECT_LT(stiff.turn.norm(), offset.left.turn.norm());
  }
}

TEST(Footing, FeetThatStandDoNotCreepApartUnderAWrongMass) {  // 25 mm in two minutes, once
  const RobotModel robot = RobotModel::load("mighty");
  const World world = World::load("flat");
  const Scenario& creep = scenario_named("creep");
  for (const std::uint64_t seed : {0u, 1u}) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant_of(creep, robot, seed);
    Simulation simulation(robot, world, Simulation::On::sim, {.physics = parameters});
    Session& session = simulation.session();
    const auto stick = stick_of(creep, robot, seed);
    Kinematics kinematics(robot);
    Pose before;
    while (session.t() < 40.0) {
      session.step(*stick);
      ASSERT_FALSE(session.fallen());
      if (std::abs(session.t() - 8.0) > 1e-6 && session.t() < 40.0 - 1e-6) continue;
      kinematics.set(session.truth()->q);
      const Pose between = kinematics.sole(Side::left).inverse() * kinematics.sole(Side::right);
      if (session.t() < 9.0) {
        before = between;
      } else {
        EXPECT_LT((between.p - before.p).norm(), 2.5e-4);
        EXPECT_LT(rotation_error(between.R, before.R).norm(), 1e-3);
        EXPECT_GT(session.navigator().committed(), 30);
      }
    }
  }
}

TEST_P(FootingTest, AFootInTheAirGoesBackInclinedAsTheFloorIs) {
  for (int trial = 0; trial < 50; ++trial) {
    const Side up = random_.coin() ? Side::left : Side::right;
    const Side stands = other(up);
    const bool slope = random_.coin();
    const Vec3 floor = slope ? random_.horizontal(0.05) : Vec3(Vec3::Zero());
    BySide<Footing::Offset> away{some_offset(), some_offset()};
    State state = as_planned(held_, halves_);
    for (const Side side : kSides) {
      away[side].turn = floor;
      state.sole[side] = displaced(held_.sole[side], away[side]);
    }
    Footing footing(robot_);
    for (int tick = 0; tick < 15 * second_; ++tick)
      footing.follow(held_, held_, state, halves_);
    ASSERT_GT(footing.offset()[up].p.norm(), 0.0);

    MotionSample lifted = held_;
    lifted.contact[up] = false;
    BySide<Wrench> wanted;
    wanted[stands] = load(1.0);
    state.force = wanted;
    const auto hold_up = [&] {
      state.sole[up] = {random_.vector(size_), rotation_exp(random_.vector(1.0))};  // wherever that is
      footing.follow(lifted, lifted, state, wanted);
      return footing.offset()[up].p.norm();
    };
    double high = footing.offset()[up].p.norm();
    for (int tick = 0; tick < 2 * second_; ++tick) {
      const double now = hold_up();
      ASSERT_LT(now, high) << "lower at every tick";
      high = now;
    }
    EXPECT_LT(high, 1e-6 * size_);
    const Vec3 turn = footing.offset()[up].turn;
    EXPECT_LT((turn - floor).norm(), kLevel + 0.05 * std::exp(-0.3 * 15.0)) << "trial " << trial;
    if (!slope) {
      EXPECT_LT(turn.norm(), 1e-6);
    }

    // The edge of a tile under the other one, for a moment, is no floor.
    const Vec3 tile = random_.horizontal(0.1);
    state.sole[stands].R = rotation_exp(tile) * state.sole[stands].R;
    for (int tick = 0; tick < second_ / 5; ++tick)
      hold_up();
    EXPECT_LT((footing.offset()[up].turn - turn).norm(), 0.3 * 0.2 * tile.norm() + kLevel);
    EXPECT_GT((footing.offset()[stands].turn - floor).norm(), 0.7 * tile.norm() - 2.0 * kLevel);
  }
}

TEST_P(FootingTest, AFootInTheAirIsAsHighAndLevelAsPlannedThoughTheTrunkIsNot) {
  for (int trial = 0; trial < 50; ++trial) {
    const Side up = random_.coin() ? Side::left : Side::right;
    MotionSample lifted = held_;
    lifted.contact[up] = false;
    lifted.sole[up].p += random_.vector(0.1 * size_);
    BySide<Wrench> wanted;
    wanted[other(up)] = load(1.0);
    // The trunk sags and leans, by what servos give way, and the whole robot is turned and elsewhere.
    State state = as_planned(lifted, wanted);
    const Mat3 lean = rotation_z(random_(-0.1, 0.1)) * rotation_exp(random_.horizontal(0.03));
    const Vec3 sag = random_.vector(0.01 * size_);
    const Eigen::Quaterniond planned(lifted.q[3], lifted.q[4], lifted.q[5], lifted.q[6]);
    const Eigen::Quaterniond turned(lean * planned.toRotationMatrix());
    state.q.segment<4>(3) << turned.w(), turned.x(), turned.y(), turned.z();
    state.q.head<3>() += sag;
    Footing footing(robot_);
    for (int tick = 0; tick < second_; ++tick)
      footing.follow(lifted, lifted, state, wanted);
    // Where the leg takes the sole, seen from the trunk that is off.
    const Footing::Offset& offset = footing.offset()[up];
    const Vec3 root = lifted.q.head<3>();
    const Pose sole = displaced(lifted.sole[up], offset);
    const Vec3 at = state.q.head<3>() + lean * (sole.p - root);
    const double band = 4e-4 * size_ + 1e-3 * (sole.p - root).norm() + 0.05 * std::abs(lean(2, 2) - 1.0) * size_;
    EXPECT_NEAR(at.z(), lifted.sole[up].p.z(), band);
    EXPECT_LT(tilt_of(lean * sole.R), tilt_of(lifted.sole[up].R) + 2e-3);
    EXPECT_EQ(offset.p.head<2>(), Vec2::Zero()) << "it is placed relative to the trunk, so that it lands below it";
    EXPECT_EQ(offset.turn.z(), 0.0);
  }
}

TEST_P(FootingTest, AFootOnItsWayUpDoesNotClingToWhatItLeaves) {
  for (int trial = 0; trial < 50; ++trial) {
    const Side up = random_.coin() ? Side::left : Side::right;
    const Footing::Offset away = some_offset();
    State state = as_planned(held_, halves_);
    state.sole[up] = displaced(held_.sole[up], away);
    MotionSample lifted = held_;
    lifted.contact[up] = false;
    for (const double rise : {0.0, random_(1e-5, 1e-3) * size_}) {  // it is held up there, or rises
      Footing footing(robot_);
      for (int tick = 0; tick < second_; ++tick)
        footing.follow(held_, held_, state, halves_);
      MotionSample next = lifted;
      next.sole[up].p.z() += rise;
      double high = footing.offset()[up].p.norm();
      for (int tick = 0; tick < second_; ++tick) {
        footing.follow(lifted, next, state, halves_);  // though it still carries
        ASSERT_LT(footing.offset()[up].p.norm(), high);
        high = footing.offset()[up].p.norm();
      }
      EXPECT_LT(high, 1e-4 * size_);
      // On its way down it follows.
      next.sole[up].p.z() = lifted.sole[up].p.z() - 1e-4 * size_;
      for (int tick = 0; tick < 2 * second_; ++tick)
        footing.follow(lifted, next, state, halves_);
      EXPECT_LT((footing.offset()[up].p - away.p).norm(), kExact * size_);
    }
  }
}

TEST_P(FootingTest, ASoleThatTipsOverItsEdgeSaysNothingAboutTheGround) {
  for (int trial = 0; trial < 100; ++trial) {
    const Side side = random_.coin() ? Side::left : Side::right;
    Footing::Offset away = some_offset();
    away.turn *= 0.04 / away.turn.norm();
    const auto& vertices = robot_.sole(side).vertices();
    const std::size_t i = random_.below(vertices.size());
    const double along = random_(0.0, 1.0);
    const Vec2 edge = (1.0 - along) * vertices[i] + along * vertices[(i + 1) % vertices.size()];
    for (const double share : {0.97, 1.05, 0.3}) {  // just inside, beyond, and well within
      State state = as_planned(held_, halves_);
      state.sole[side] = displaced(held_.sole[side], away);
      state.force[side] = load_at(0.5, state.sole[side], share * edge);
      BySide<Wrench> wanted = halves_;
      wanted[side] = state.force[side];  // it is as it should be: no reason to yield
      Footing footing(robot_);
      for (int tick = 0; tick < 2 * second_; ++tick)
        footing.follow(held_, held_, state, wanted);
      const Footing::Offset& offset = footing.offset()[side];
      if (share > 0.9) {
        ASSERT_TRUE(offset.turn.isZero(0.0)) << share;
      } else {
        ASSERT_LT((offset.turn - away.turn).norm(), kLevel) << share;
      }
      ASSERT_LT((offset.p - away.p).norm(), kExact * size_) << "where it is counts all the same";
    }
  }
}

TEST_P(FootingTest, OnGroundThatWasFeltToBeSoftASoleYieldsFasterAndToLess) {
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 way = random_.direction();
    const auto after = [&](double compliance, double excess) {
      Footing footing(robot_);
      BySide<Wrench> force = halves_;
      const double unit = weight_ * size_;
      for (int tick = 0; tick < 20 * second_; ++tick) {
        const Vec3 moment = 0.03 * std::sin(0.3 + 8.0 * tick / second_) * way;  // within the dead band
        State state = as_planned(held_, halves_);
        state.force.left.moment += moment * unit;
        BySide<Wrench> wanted = halves_;
        wanted.left.moment += moment * unit;
        state.sole.left.R = rotation_exp(-compliance * moment) * state.sole.left.R;
        footing.follow(held_, held_, state, wanted);
      }
      const Vec3 before = footing.offset().left.turn;
      force.left.moment += excess * unit * way;
      for (int tick = 0; tick < 4; ++tick)
        footing.follow(held_, held_, as_planned(held_, force), halves_);
      return (footing.offset().left.turn - before).dot(way);
    };
    const double firm = after(0.0, 0.05);
    EXPECT_GT(firm, 0.0);
    EXPECT_GT(after(1.0, 0.05), 2.0 * firm);
    EXPECT_EQ(after(0.0, 0.015), 0.0) << "within the dead band";
    EXPECT_GT(after(1.0, 0.015), 0.0);
  }
}

}  // namespace
}  // namespace baton
