#include "baton/balance/odometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "baton/balance/state.hpp"
#include "baton/ik/inverse_kinematics.hpp"
#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;
using testing::HasSubstr;

/// One tick of a run: what was measured, the truth about the root with it, and what was planned.
struct Moment {
  Measurement measured;
  MotionSample planned;
};

/// Joints that swing about where they begin, each at its own pace, from rest.
class Sway {
 public:
  Sway(const VecX& about, double most, Random& random) : about_(about), by_(about.size()), pace_(about.size()) {
    for (Eigen::Index j = 0; j < about.size(); ++j) {
      by_[j] = random(-most, most);
      pace_[j] = random(2.0, 8.0);
    }
  }
  [[nodiscard]] VecX q(double t) const { return about_.array() + by_.array() * (1.0 - (pace_ * t).array().cos()); }
  [[nodiscard]] VecX dq(double t) const { return by_.array() * pace_.array() * (pace_ * t).array().sin(); }
  [[nodiscard]] VecX ddq(double t) const { return by_.array() * pace_.array().square() * (pace_ * t).array().cos(); }

 private:
  VecX about_, by_, pace_;
};

class OdometryTest : public testing::TestWithParam<std::string> {
 protected:
  /// Lives through a run, tick by tick.
  static void live(Session& session, double seconds, const std::function<Command(double)>& stick,
                   const std::function<void(const Moment&)>& on_tick) {
    Hooks hooks;
    session.add(hooks);
    hooks.tick = [&](const TickRecord& record) { on_tick({record.measurement, record.navigator.sample()}); };
    while (session.t() < seconds)
      session.step(stick(session.t()));
    ASSERT_FALSE(session.fallen()) << session.truth()->fall;
  }

  /// A run on ideal: every part is guided, at random, one after the other. Made once a process.
  const std::vector<Moment>& wandering() {
    static std::map<std::string, std::vector<Moment>> known;
    std::vector<Moment>& run = known[GetParam()];
    if (!run.empty()) return run;
    Simulation simulation(robot_, world_, Simulation::On::ideal);
    Session& session = simulation.session();
    Random random(21);
    Command command;
    double until = 0.0;
    const auto stick = [&](double t) {
      if (t < until) return command;
      command.guide = kParts[random.below(kParts.size())];
      for (double& axis : command.axes)
        axis = random(-1.0, 1.0);
      until = t + 0.8;
      return command;
    };
    live(session, 8.0, stick, [&](const Moment& moment) { run.push_back(moment); });
    EXPECT_GT(session.navigator().committed(), 8);
    return run;
  }

  /// Forward, without end.
  static Command forward(double t) {
    Command command;
    if (t > 0.3) command.axes[0] = 1.0;
    return command;
  }

  /// What it makes of the sensors alone: the root, which no sensor gives, is hidden from it.
  static const Measurement& feed(Odometry& odometry, Measurement measured, const MotionSample& planned) {
    measured.root.reset();
    return odometry.update(measured, planned);
  }

  /// Both soles with some of the weight, in their middles.
  [[nodiscard]] Measurement loaded(Measurement measured, double left, double right) const {
    measured.sole.left = {Vec3(0, 0, left * weight_), Vec3::Zero()};
    measured.sole.right = {Vec3(0, 0, right * weight_), Vec3::Zero()};
    return measured;
  }

  /// A configuration with other joint angles.
  static VecX with_joints(VecX q, const VecX& joints) {
    q.tail(joints.size()) = joints;
    return q;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const World world_ = World::load("flat");
  const double size_ = robot_.profile().stance.com_height;
  const double speed_ = std::sqrt(kGravity * size_);
  const double period_ = robot_.profile().tick.period;
  const double weight_ = robot_.mass() * kGravity;
  const int n_ = robot_.nv() - 6;
  const Posture home_ = stand(robot_, world_.site("start"), size_);
  Random random_{12};
};

INSTANTIATE_TEST_SUITE_P(Robots, OdometryTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(OdometryTest, OnOneLegTheRootIsWhereTheLegSays) {
  double fastest = 0.0;
  for (int trial = 0; trial < 10; ++trial) {
    // By forward kinematics, so that the soles are where the joints say, to rounding.
    const Posture start = posture_of(robot_, stand(robot_, random_.on_the_floor(), size_).q);
    const Sway sway(start.q.tail(n_), 0.05, random_);
    IdealRobot body(robot_, start, period_);
    Odometry odometry(robot_, world_, StateSource::sensors, start);
    MotionSample planned = resting(robot_, start);
    JointTarget target;
    target.tau = VecX::Zero(n_);
    target.contact = planned.contact = {trial % 2 == 0, trial % 2 == 1};
    for (int tick = 0; tick < 200; ++tick) {
      const Measurement truth = body.read();
      const Measurement& found = feed(odometry, truth, planned);
      ASSERT_TRUE(found.root);
      ASSERT_LT((found.root->pose.p - truth.root->pose.p).norm(), 1.2e-2 * size_) << trial << " at " << tick;
      ASSERT_LT((found.root->pose.R - truth.root->pose.R).norm(), 1.5e-2);
      ASSERT_LT((found.root->velocity - truth.root->velocity).norm(), 3e-3 * speed_) << trial << " at " << tick;
      ASSERT_LT((found.root->rate - truth.root->rate).norm(), 1e-9);
      fastest = std::max(fastest, truth.root->velocity.norm());
      const double t = (tick + 1) * period_;
      target.q = sway.q(t);
      target.dq = planned.dq.tail(n_) = sway.dq(t);
      target.ddq = planned.ddq.tail(n_) = sway.ddq(t);
      body.write(target);
    }
    EXPECT_FALSE(odometry.touch()[trial % 2 == 0 ? Side::right : Side::left]);
  }
  EXPECT_GT(fastest, 0.02 * speed_);
}

TEST_P(OdometryTest, WalkingOnIdealGroundItKnowsTheRoot) {
  Simulation simulation(robot_, world_, Simulation::On::ideal);
  Session& session = simulation.session();
  Odometry odometry(robot_, world_, StateSource::sensors, home_);
  Vec3 place = home_.q.head<3>();
  live(session, 5.0, forward, [&](const Moment& moment) {
    const Measurement& found = feed(odometry, moment.measured, moment.planned);
    const RootMeasurement& truth = *moment.measured.root;
    EXPECT_LT((found.root->pose.p - truth.pose.p).norm(), 7e-4 * size_) << moment.measured.t;
    EXPECT_LT((found.root->velocity - truth.velocity).norm(), 1e-3 * speed_) << moment.measured.t;
    place = truth.pose.p;
  });
  EXPECT_GT((place - home_.q.head<3>()).norm(), 0.5 * size_);
}

TEST_P(OdometryTest, WhateverTheStickAsksForItStraysNoFartherThanThePlanMay) {
  // A sole that stands is moved by what inverse kinematics leaves, and heights are the ground's, not that sole's.
  Odometry odometry(robot_, world_, StateSource::sensors, home_);
  int on_one_leg = 0;
  for (const Moment& moment : wandering()) {
    const Measurement& found = feed(odometry, moment.measured, moment.planned);
    const RootMeasurement& truth = *moment.measured.root;
    ASSERT_LT((found.root->pose.p - truth.pose.p).norm(), 8.0 * robot_.profile().ik.position) << moment.measured.t;
    ASSERT_LT((found.root->pose.R - truth.pose.R).norm(), 3e-3);
    ASSERT_LT((found.root->velocity - truth.velocity).norm(), 1.2e-3 * speed_) << moment.measured.t;
    ASSERT_LT((found.root->rate - truth.rate).norm(), 1e-9);
    ASSERT_EQ(found.q, moment.measured.q);
    on_one_leg += moment.planned.contact.left && moment.planned.contact.right ? 0 : 1;
  }
  EXPECT_GT(on_one_leg, 100);
}

TEST_P(OdometryTest, TorquesTellTheLoadsAsForcesDo) {
  Odometry by_forces(robot_, world_, StateSource::sensors, home_);
  Odometry by_torques(robot_, world_, StateSource::torques, home_);
  std::vector<double> each;
  std::vector<double> both;
  for (const Moment& moment : wandering()) {
    static_cast<void>(feed(by_forces, moment.measured, moment.planned));
    Measurement no_forces = moment.measured;  // that it does not look at them
    no_forces.sole = {};
    const Measurement& found = feed(by_torques, no_forces, moment.planned);
    if (moment.measured.t == 0.0) continue;  // no torque has been asked for yet
    const auto off = [&](Side side) { return (by_torques.load()[side] - by_forces.load()[side]) / weight_; };
    both.push_back(std::abs(off(Side::left) + off(Side::right)));
    ASSERT_LT(both.back(), 0.15) << moment.measured.t;
    for (const Side side : kSides) {
      each.push_back(std::abs(off(side)));
      if (moment.planned.contact.left && moment.planned.contact.right) continue;
      // On one leg there is but one way to share.
      ASSERT_LT(each.back(), 0.1) << moment.measured.t;
      ASSERT_LT((found.sole[side].force - moment.measured.sole[side].force).norm(), 0.1 * weight_);
    }
    ASSERT_LT((found.root->pose.p - moment.measured.root->pose.p).norm(), 12.0 * robot_.profile().ik.position);
  }
  // Forces are what a tick took on average, torques are made for its end. While accelerations change quickly, that
  // moves the ZMP, and with it the load from one sole to the other.
  for (std::vector<double>* all : {&both, &each})
    std::sort(all->begin(), all->end());
  EXPECT_LT(both[both.size() * 99 / 100], 0.02);
  EXPECT_LT(each[each.size() / 2], 0.005);
  EXPECT_LT(each[each.size() * 99 / 100], 0.15);
}

TEST_P(OdometryTest, WhichWayTheImuTakesForNorthDoesNotMatter) {
  Odometry straight(robot_, world_, StateSource::sensors, home_);
  struct Turned {
    Mat3 by;
    Odometry odometry;
  };
  std::vector<Turned> all;
  for (const double angle : {random_(-1.0, 1.0), random_(1.0, 3.0), random_(-3.0, -1.0), M_PI})
    all.push_back({rotation_z(angle), Odometry(robot_, world_, StateSource::sensors, home_)});
  for (const Moment& moment : wandering()) {
    const Measurement& found = feed(straight, moment.measured, moment.planned);
    for (Turned& turned : all) {
      Measurement measured = moment.measured;
      measured.imu.attitude = turned.by * measured.imu.attitude;
      const Measurement& same = feed(turned.odometry, measured, moment.planned);
      ASSERT_LT((same.root->pose.p - found.root->pose.p).norm(), 1e-9 * size_) << moment.measured.t;
      ASSERT_LT((same.root->pose.R - found.root->pose.R).norm(), 1e-9);
      ASSERT_LT((same.root->velocity - found.root->velocity).norm(), 1e-9 * speed_);
      ASSERT_NEAR(turned.odometry.load().left, straight.load().left, 1e-9 * weight_);
    }
  }
}

TEST_P(OdometryTest, AFootThatTouchesNothingIsNotBelieved) {
  const MotionSample held = resting(robot_, home_);  // as if both were to stand
  const Measurement still = IdealRobot(robot_, home_, period_).read();
  for (int trial = 0; trial < 10; ++trial) {
    const Side moves = trial % 2 == 0 ? Side::left : Side::right;
    const Sway sway(home_.q.tail(n_), 0.1, random_);
    Odometry odometry(robot_, world_, StateSource::sensors, home_);
    Odometry deceived(robot_, world_, StateSource::sensors, home_);
    double misled = 0.0;
    for (int tick = 0; tick < 200; ++tick) {
      Measurement measured = still;
      for (const int j : robot_.leg(moves)) {
        measured.q[j] = sway.q(tick * period_)[j];
        measured.dq[j] = sway.dq(tick * period_)[j];
      }
      MotionSample planned = held;
      planned.dq.tail(n_) = measured.dq;
      // It has left the ground; what makes it touch again is more than what made it leave.
      const double light = tick < 50 ? random_(0.0, 0.02) : random_(0.0, 0.045);
      const bool left = moves == Side::left;
      const Measurement& found =
          feed(odometry, loaded(measured, left ? light : 1.0 - light, left ? 1.0 - light : light), planned);
      ASSERT_LT((found.root->pose.p - home_.q.head<3>()).norm(), 1e-6 * size_) << trial << " at " << tick;
      ASSERT_LT(found.root->velocity.norm(), 1e-6 * speed_);
      ASSERT_FALSE(odometry.touch()[moves]);
      ASSERT_TRUE(odometry.touch()[other(moves)]);
      ASSERT_LE(odometry.load()[moves], light * weight_ + 1e-9 * weight_);
      // With half of the weight on it, it is believed.
      const Measurement& other_one = feed(deceived, loaded(measured, 0.5, 0.5), planned);
      misled = std::max(misled, (other_one.root->pose.p - home_.q.head<3>()).norm());
    }
    EXPECT_GT(misled, 2e-3 * size_);
  }
}

TEST_P(OdometryTest, AFootThatSeemsToLandEarlyLandsWhereItDoes) {
  // As loads that are estimated from motor torques tell, of a foot that is being put down.
  Odometry odometry(robot_, world_, StateSource::sensors, home_);
  Odometry exact(robot_, world_, StateSource::sensors, home_);
  const std::vector<Moment>& run = wandering();
  constexpr std::size_t kEarly = 8;  // ticks
  double worst = 0.0;
  long early = 0;
  for (std::size_t i = 0; i + kEarly < run.size(); ++i) {
    Measurement measured = run[i].measured;
    for (const Side side : kSides) {
      if (run[i].planned.contact[side] || !run[i + kEarly].planned.contact[side]) continue;
      measured.sole[side].force.z() = random_(0.06, 0.12) * weight_;
      ++early;
    }
    const Vec3 place = feed(odometry, measured, run[i].planned).root->pose.p;
    const Vec3 should = feed(exact, run[i].measured, run[i].planned).root->pose.p;
    worst = std::max(worst, std::abs((place - should).z()));
  }
  EXPECT_GT(early, 8);
  EXPECT_LT(worst, 5e-3 * size_);
}

TEST_P(OdometryTest, HeightsAreSlowlyPulledToTheGround) {
  const MotionSample held = resting(robot_, home_);
  const Measurement still = IdealRobot(robot_, home_, period_).read();
  const auto believed = [&](double higher) {
    Posture start = home_;
    start.q[2] += higher;
    for (const Side side : kSides)
      start.sole[side].p.z() += higher;
    return start;
  };
  const int second = static_cast<int>(std::lround(6.14 / (robot_.omega() * period_)));         // for mighty
  for (const double higher : {0.008 * size_, -0.008 * size_, random_(-0.02, 0.02) * size_}) {  // 2 mm, or some
    Odometry odometry(robot_, world_, StateSource::sensors, believed(higher));
    double off = std::abs(higher);
    for (int tick = 0; tick < 5 * second; ++tick) {
      const Vec3 error = feed(odometry, still, held).root->pose.p - home_.q.head<3>();
      ASSERT_LT(error.head<2>().norm(), 1e-6 * size_);
      ASSERT_LE(std::abs(error.z()), off + 1e-9 * size_) << tick;
      off = std::abs(error.z());
      if (tick < second / 20) {
        ASSERT_GT(off, 0.9 * std::abs(higher)) << "a step, not a drift";
      }
    }
    EXPECT_LT(off, 0.02 * std::abs(higher) + 1e-6 * size_);
  }
  // As far off as this, one sole may stand on something that is not on the map; both are rather the map's ground.
  for (const double higher : {0.1 * size_, -0.1 * size_}) {
    Odometry on_one(robot_, world_, StateSource::sensors, believed(higher));
    Odometry on_both(robot_, world_, StateSource::sensors, believed(higher));
    MotionSample one = held;
    one.contact.right = false;
    double off_on_one = 0.0, off_on_both = 0.0;
    for (int tick = 0; tick < 5 * second; ++tick) {
      off_on_one = feed(on_one, loaded(still, 1.0, 0.0), one).root->pose.p.z() - home_.q[2];
      off_on_both = feed(on_both, still, held).root->pose.p.z() - home_.q[2];
    }
    EXPECT_NEAR(off_on_one, higher, 1e-6 * size_);
    EXPECT_LT(std::abs(off_on_both), 0.02 * std::abs(higher));
  }
}

TEST_P(OdometryTest, ALightlyLoadedSoleThatTiltsPivotsAboutItsCentreOfPressure) {
  const Measurement still = IdealRobot(robot_, home_, period_).read();
  MotionSample held = resting(robot_, home_);
  held.contact.right = false;
  const Mat3 upright = still.imu.attitude;
  const Mat3 sole = home_.sole.left.R;
  for (const auto& [load, fore_and_aft] : {std::pair(0.3, false), {0.3, true}, {1.0, true}}) {
    const Vec2 corner = robot_.sole(Side::left).vertices().front().cwiseAbs();
    const Vec3 edge = fore_and_aft ? Vec3(corner.x(), 0, 0) : Vec3(0, corner.y(), 0);
    const Vec3 axis = sole * (fore_and_aft ? Vec3::UnitY() : Vec3(-Vec3::UnitX()));  // up at the far side
    Odometry odometry(robot_, world_, StateSource::sensors, home_);
    const auto side_at = [](double tick) { return std::sin(2.0 * M_PI * tick / 60.0) < 0.0 ? -1.0 : 1.0; };
    const auto turned = [&](double tick) {
      return rotation_exp(0.015 * std::pow(std::sin(2.0 * M_PI * tick / 60.0), 2) * side_at(tick) * axis);
    };
    const auto root = [&, load = load](double tick) {
      const Vec3 fixed = load < 0.4 ? Vec3(side_at(tick) * edge) : Vec3::Zero();  // one that is pushed rolls and yields
      const Vec3 pivot = home_.sole.left.p + sole * fixed;
      return Pose{pivot + turned(tick) * (home_.q.head<3>() - pivot), turned(tick) * upright};
    };
    const auto imu = [&](double tick) { return root(tick) * *robot_.imu_in_root(); };
    for (int tick = 0; tick < 600; ++tick) {  // from edge to edge, ten times
      const double phase = 2.0 * M_PI * tick / 60.0;
      const double rate = 0.015 * 2.0 * std::sin(phase) * std::cos(phase) * 2.0 * M_PI / 60.0 / period_ * side_at(tick);
      Measurement measured = loaded(still, load, 0.0);
      measured.imu.attitude = imu(tick).R;
      measured.imu.rate = measured.imu.attitude.transpose() * (rate * axis);
      const Vec3 acceleration = (imu(tick + 1).p - 2.0 * imu(tick).p + imu(tick - 1).p) / (period_ * period_);
      measured.imu.acceleration = measured.imu.attitude.transpose() * (acceleration + Vec3(0, 0, kGravity));
      const Vec3 force = (turned(tick) * sole).transpose() * Vec3(0, 0, load * weight_);
      measured.sole.left = {force, Vec3(side_at(tick) * edge).cross(force)};
      ASSERT_LT((feed(odometry, measured, held).root->pose.p - root(tick).p).norm(), 2e-3 * size_) << tick;
    }
  }
}

TEST_P(OdometryTest, PutDownAfterItWasLiftedItStandsOnTheGroundAgain) {
  const MotionSample held = resting(robot_, home_);
  const Measurement still = IdealRobot(robot_, home_, period_).read();
  for (const double lifted : {0.2, 1.0, 3.0}) {
    for (const double drift : {-0.5, 0.5}) {  // of the accelerometer [m/s²]
      Odometry odometry(robot_, world_, StateSource::sensors, home_);
      double highest = 0.0;
      for (double t = 0.0; t < lifted; t += period_) {
        Measurement measured = loaded(still, 0.0, 0.0);
        measured.imu.acceleration.z() += drift;
        highest = std::max(highest, std::abs(feed(odometry, measured, held).root->pose.p.z() - home_.q[2]));
      }
      Vec3 error = Vec3::Zero();
      for (int tick = 0; tick < std::lround(1.0 / period_); ++tick)
        error = feed(odometry, loaded(still, 0.5, 0.5), held).root->pose.p - home_.q.head<3>();
      EXPECT_LT(std::abs(error.z()), 0.05 * size_) << lifted << " s, " << highest << " m";
    }
  }
}

/// The same posture, `by` [m] farther along x.
Posture moved_ahead(Posture posture, double by) {
  posture.q[0] += by;
  for (const Side side : kSides)
    posture.sole[side].p.x() += by;
  return posture;
}

TEST(OdometryByEdges, ASoleThatStandsOnAnEdgeTellsWhereTheRobotIs) {
  const RobotModel& robot = test::robot("mighty");
  const World room = World::load("room");  // the stage ends at 0.12, 15 mm higher than the tread
  const double half = robot.sole(Side::left).vertices().front().cwiseAbs().x();
  const double on_the_edge = 0.0035;
  const double along = 2.0 * half - on_the_edge;
  const double tilt = std::asin(0.015 / along);
  const Vec3 toe(0.12 + along * std::cos(tilt), 0.042, 0.015);
  const Vec3 middle(toe.x() - half, 0.0, 0.015);
  const Posture flat = stand(robot, {middle, Mat3::Identity()}, 0.26);
  IkTargets targets;
  targets.com = flat.com + Vec3(0, 0, 0.004);
  targets.sole = flat.sole;
  targets.sole.right.p.x() += 2.0 * on_the_edge;  // off the stage
  targets.sole.left.R = rotation_exp(Vec3(0, tilt, 0));
  targets.sole.left.p = toe - targets.sole.left.R * Vec3(half, 0, 0);
  targets.arms = flat.q.tail(robot.nv() - 6);
  InverseKinematics ik(robot);
  VecX q = flat.q;
  for (int k = 0; k < 20; ++k)
    ik.solve(targets, q, std::numeric_limits<double>::infinity(), q, 10);
  const Posture start = posture_of(robot, q);
  ASSERT_LT((start.sole.left.p - targets.sole.left.p).norm(), 1e-5);
  const double period = robot.profile().tick.period;
  const Measurement still = [&] {
    Measurement measured = IdealRobot(robot, start, period).read();
    for (const Side side : kSides)
      measured.sole[side] = {Vec3(0, 0, 0.5 * robot.mass() * kGravity), Vec3::Zero()};
    measured.root.reset();
    return measured;
  }();
  for (const double farther : {0.0, 0.002, 0.004, 0.006, 0.008}) {
    const Posture believed = moved_ahead(start, farther);
    Odometry odometry(robot, room, StateSource::sensors, believed);
    const MotionSample held = resting(robot, believed);
    Vec3 error = Vec3::Zero();
    double last = farther;
    for (int tick = 0; tick < 400; ++tick) {
      error = odometry.update(still, held).root->pose.p - start.q.head<3>();
      ASSERT_LE(error.x(), last + 1e-9);
      ASSERT_GT(error.x(), last - 1e-4) << "a drift, not a jump";
      last = error.x();
    }
    EXPECT_LT(std::abs(error.x()), 1.2e-3) << farther;
    EXPECT_NEAR(error.y(), 0.0, 1e-6);
    EXPECT_NEAR(error.z(), 0.0, 2e-4) << "the other sole tells the height";
  }
}

TEST(OdometryByEdges, ALevelSoleHasNoCornerInsideHigherGround) {
  const RobotModel& robot = test::robot("mighty");
  const World room = World::load("room");  // the stage ends at 0.12, 15 mm higher than the tread
  const double period = robot.profile().tick.period;
  const double heel = -robot.sole(Side::left).vertices().front().cwiseAbs().x();
  const double outset = 0.002 * robot.profile().stance.com_height;
  for (const double gap : {0.004, 0.008, 0.012}) {  // true gap between the heels and the stage
    const Vec3 centre(0.12 - heel + gap, 0.0, 0.015);
    const Posture start = stand(robot, {centre, Mat3::Identity()}, 0.26);
    Measurement still = IdealRobot(robot, start, period).read();
    still.root.reset();
    for (const double behind : {0.001, 0.010, 0.018, 0.030}) {
      const Posture believed = moved_ahead(start, -behind);
      Odometry odometry(robot, room, StateSource::sensors, believed);
      const MotionSample held = resting(robot, believed);
      Vec3 error = Vec3(-behind, 0, 0);
      for (int tick = 0; tick < 600; ++tick) {
        const Vec3 now = odometry.update(still, held).root->pose.p - start.q.head<3>();
        ASSERT_LT((now - error).norm(), 1e-4) << "a drift, not a jump";
        error = now;
      }
      EXPECT_NEAR(error.x(), -std::min(behind, gap - outset), 1e-3) << behind << ", " << gap;
      EXPECT_NEAR(error.y(), 0.0, 1e-6);
      EXPECT_NEAR(error.z(), 0.0, 2e-4);
    }
  }
}

TEST(OdometryByEdges, ALevelSoleIsNotBeyondTheEdgeOfItsGround) {
  const RobotModel& robot = test::robot("mighty");
  const World room = World::load("room");  // the stage ends at 0.12, 15 mm higher than the tread
  const Posture start = stand(robot, {Vec3(0.11, 0.0, 0.03), Mat3::Identity()}, 0.26);  // centres 10 mm before it
  Measurement still = IdealRobot(robot, start, robot.profile().tick.period).read();
  still.root.reset();
  for (const double ahead : {0.004, 0.014, 0.03}) {
    const Posture believed = moved_ahead(start, ahead);
    Odometry odometry(robot, room, StateSource::sensors, believed);
    const MotionSample held = resting(robot, believed);
    Vec3 error = Vec3::Zero();
    for (int tick = 0; tick < 600; ++tick)
      error = odometry.update(still, held).root->pose.p - start.q.head<3>();
    EXPECT_NEAR(error.x(), std::min(ahead, 0.01), 1e-3) << ahead;
    EXPECT_NEAR(error.z(), 0.0, 2e-4);
  }
}

TEST_P(OdometryTest, InPhysicsItStraysLittleAndItsDcmIsSmooth) {
  Simulation simulation(robot_, world_, Simulation::On::sim);
  Session& session = simulation.session();
  Odometry odometry(robot_, world_, StateSource::sensors, home_);
  Estimator estimator(robot_);
  Estimator perfect(robot_);
  const double omega = robot_.omega();
  Vec3 error = Vec3::Zero();
  double way = 0.0;
  double worst = 0.0;
  double squares = 0.0;
  int ticks = 0;
  live(session, 15.0, forward, [&](const Moment& moment) {
    const Measurement& found = feed(odometry, moment.measured, moment.planned);
    const RootMeasurement& truth = *moment.measured.root;
    error = found.root->pose.p - truth.pose.p;
    way = (truth.pose.p - home_.q.head<3>()).head<2>().norm();
    EXPECT_LT(error.head<2>().norm(), 0.01 * (way + size_)) << moment.measured.t;
    EXPECT_LT(std::abs(error.z()), 0.01 * size_) << moment.measured.t;
    // Seen from the root, so that the way does not count.
    const Vec3 dcm = estimator.update(found, Pose{}).dcm(omega) - found.root->pose.p;
    const Vec3 true_dcm = perfect.update(moment.measured, Pose{}).dcm(omega) - truth.pose.p;
    const double off = (dcm - true_dcm).head<2>().norm();
    worst = std::max(worst, off);
    squares += off * off;
    ++ticks;
  });
  EXPECT_GT(way, 2.0 * size_);
  EXPECT_LT(error.head<2>().norm(), 0.01 * way);
  // It says so itself: in proportion to the way, from footfall to footfall.
  EXPECT_NEAR(odometry.uncertainty(), 0.025 * way, 0.005 * way);
  EXPECT_LT(std::sqrt(squares / ticks), 0.003 * size_);
  EXPECT_LT(worst, 0.01 * size_);
}

TEST_P(OdometryTest, PlayInTheJointsDoesNotLeadItAstray) {
  Simulation::Parameters parameters;
  parameters.physics.plant.actuators.backlash = 0.0044;
  Simulation simulation(robot_, world_, Simulation::On::sim, parameters);
  Session& session = simulation.session();
  Odometry odometry(robot_, world_, StateSource::sensors, home_);
  Odometry without_torques(robot_, world_, StateSource::sensors, home_);
  double way = 0.0;
  double error = 0.0;
  double uncorrected = 0.0;
  live(session, 25.0, forward, [&](const Moment& moment) {
    const Vec3& truth = moment.measured.root->pose.p;
    const auto off = [&](const Measurement& found) { return (found.root->pose.p - truth).head<2>().norm(); };
    error = off(feed(odometry, moment.measured, moment.planned));
    Measurement no_torques = moment.measured;
    no_torques.torque.resize(0);
    uncorrected = off(feed(without_torques, no_torques, moment.planned));
    way = (truth - home_.q.head<3>()).head<2>().norm();
  });
  EXPECT_GT(way, 4.0 * size_);
  EXPECT_LT(error, 0.012 * way);
  EXPECT_GT(uncorrected, 2.0 * error);
}

TEST_P(OdometryTest, AMotorThatCrossesItsPlayMovesTheRootLittle) {
  // While it stands, the encoders of one leg turn within 30 ms, as when load passes from one leg to the other.
  const double unit = size_ * robot_.omega();
  int crossed = 0;
  double share = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    Odometry odometry(robot_, world_, StateSource::sensors, home_);
    const MotionSample planned = resting(robot_, home_);
    IdealRobot body(robot_, home_, period_);
    Measurement measured = loaded(body.read(), 0.5, 0.5);
    const Side side = trial % 2 == 0 ? Side::left : Side::right;
    VecX turns = VecX::Zero(n_);
    for (const int j : robot_.leg(side))
      turns[j] = random_(-0.015, 0.015);
    const auto sole_from_root = [&] { return posture_of(robot_, with_joints(home_.q, measured.q)).sole[side].p; };
    for (int tick = 0; tick < 20; ++tick)
      static_cast<void>(feed(odometry, measured, planned));
    const Vec3 before = sole_from_root();
    constexpr double kSeconds = 0.03;
    double fastest = 0.0;
    for (int tick = 0; tick < 60; ++tick) {
      measured.t += period_;
      const bool turning = (tick + 1) * period_ <= kSeconds + 1e-9;
      measured.dq = turning ? VecX(turns / kSeconds) : VecX(VecX::Zero(n_));
      measured.q += period_ * measured.dq;
      const Measurement& found = feed(odometry, measured, planned);
      fastest = std::max(fastest, found.root->velocity.head<2>().norm());
    }
    const Vec3 seems = sole_from_root() - before;
    if (seems.head<2>().norm() < 0.06 * unit * kSeconds) continue;
    ++crossed;
    const Vec3 root = feed(odometry, measured, planned).root->pose.p - home_.q.head<3>();
    // Both soles carry the same: believed in full, one that seems to move takes the root half of the way with it.
    share += root.head<2>().norm() / seems.head<2>().norm();
    EXPECT_LT(fastest, 0.015 * unit) << trial;
  }
  EXPECT_GT(crossed, 30);
  EXPECT_LT(share / crossed, 0.42);
}

TEST_P(OdometryTest, PerfectIsWhatIsMeasured) {
  Odometry odometry(robot_, world_, StateSource::perfect, home_);
  for (std::size_t k = 0; k < wandering().size(); k += 7) {
    const Moment& moment = wandering()[k];
    const Measurement& found = odometry.update(moment.measured, moment.planned);
    ASSERT_EQ(found.root->pose.p, moment.measured.root->pose.p);
    ASSERT_EQ(found.root->pose.R, moment.measured.root->pose.R);
    ASSERT_EQ(found.root->velocity, moment.measured.root->velocity);
    ASSERT_EQ(found.root->rate, moment.measured.root->rate);
    ASSERT_EQ(found.dq, moment.measured.dq);
  }
  EXPECT_EQ(odometry.uncertainty(), 0.0);
}

TEST_P(OdometryTest, StandingAndShiftingItLosesNoPlace) {
  Simulation simulation(robot_, world_, Simulation::On::sim);
  Session& session = simulation.session();
  const auto shifts = [](double t) {
    Command command;
    command.axes[2] = std::sin(3.0 * t);
    return command;
  };
  live(session, 8.0, shifts, [](const Moment&) {});
  EXPECT_GT(session.navigator().committed(), 5);
  EXPECT_LT(session.navigator().odometry().uncertainty(), 1e-6 * size_);
}

TEST_P(OdometryTest, WithoutAnImuOnTheRootOnlyAPerfectStateWillDo) {
  Profile none = robot_.profile();
  none.imu.clear();
  Profile on_a_hand = robot_.profile();
  on_a_hand.imu = on_a_hand.parts.hand[0];
  for (const Profile& profile : {none, on_a_hand}) {
    const RobotModel robot(profile);
    for (const StateSource source : {StateSource::sensors, StateSource::torques}) {
      try {
        const Odometry odometry(robot, world_, source, home_);
        FAIL() << "no InputError for " << to_string(source);
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("parts.imu"));
        EXPECT_THAT(error.what(), HasSubstr(std::string(to_string(source))));
      }
    }
    EXPECT_NO_THROW(Odometry(robot, world_, StateSource::perfect, home_));
  }
  EXPECT_NO_THROW(Odometry(robot_, world_, StateSource::sensors, home_));
}

}  // namespace
}  // namespace baton
