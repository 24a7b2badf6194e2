#include "baton/link/engage.hpp"

#include <gmock/gmock.h>

#include <random>

#include "baton/ik/stand.hpp"
#include "baton/link/target_check.hpp"
#include "baton/model/error.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton::link {
namespace {

using testing::HasSubstr;

class EngageTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const Eigen::Index n_ = robot_.nv() - 6;
  const double height_ = robot_.profile().stance.com_height;

  /// Joint angles of a robot that stands with its COM at this height, its arms turned at random.
  [[nodiscard]] VecX standing(double com_height, std::mt19937_64& random) const {
    std::uniform_real_distribution<double> turn(-0.4, 0.4);
    VecX q = stand(robot_, Pose{}, com_height).q.tail(n_);
    for (const Side side : kSides) {
      for (const int j : robot_.arm(side)) {
        const Range& range = robot_.joints()[static_cast<std::size_t>(j)].position;
        q[j] = std::clamp(q[j] + turn(random), range.lo + 0.1, range.hi - 0.1);
      }
    }
    return q;
  }
  [[nodiscard]] std::string refusal(const VecX& q) const {
    try {
      (void)engage(robot_, Pose{}, q);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

INSTANTIATE_TEST_SUITE_P(Robots, EngageTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(EngageTest, ItsSolesStandAtTheStartWhateverItsPosture) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (int run = 0; run < 100; ++run) {
    const VecX q = standing(height_ * (0.97 + 0.04 * share(random)), random);
    const Pose start{Vec3(share(random), share(random), 0.1 * share(random)), rotation_z(3.0 * share(random))};
    const Posture posture = engage(robot_, start, q);
    EXPECT_LT((0.5 * (posture.sole.left.p + posture.sole.right.p) - start.p).norm(), 1e-6);
    for (const Side side : kSides)
      EXPECT_LT(rotation_error(posture.sole[side].R, start.R).norm(), 1e-3);
    EXPECT_TRUE(in_stance(robot_, q) || posture.q.tail(n_) == q);
  }
}

TEST_P(EngageTest, AnglesInDegreesAndAccelerationsInUnitsOfGAreSeen) {
  std::mt19937_64 random(5);
  int named = 0;
  for (int run = 0; run < 100; ++run) {
    const VecX q = standing(height_ * 0.95, random);
    named += refusal(q * 180.0 / M_PI).find("rad: must be within its range") != std::string::npos ? 1 : 0;
    Measurement measured;
    const Vec3 up = rotation_exp(Vec3(0.2, 0.0, 0.0)) * Vec3(0.0, 0.0, 1.0);
    measured.imu.acceleration = (1.0 + 0.001 * run) * up;
    EXPECT_THAT(in_other_units(measured, StateSource::sensors).value_or(""), HasSubstr("not in units of g"));
    EXPECT_FALSE(in_other_units(measured, StateSource::perfect));
    measured.imu.acceleration = (9.3 + 0.01 * run) * up;
    EXPECT_FALSE(in_other_units(measured, StateSource::sensors));
    measured.imu.acceleration.setZero();  // as of a simulated robot that falls onto its soles first
    EXPECT_FALSE(in_other_units(measured, StateSource::sensors));
  }
  EXPECT_EQ(named, 100);
}

// In physics, from where it stands: no joint jumps, and then `home` leads to the stance.
TEST_P(EngageTest, FromAnyPostureItIsDrivenToItsStanceWithoutAJump) {
  const World world = World::load("flat");
  std::mt19937_64 random(2);
  int elsewhere = 0;
  for (int run = 0; run < 6; ++run) {
    const VecX q = standing(height_ * (0.94 + 0.01 * run), random);
    elsewhere += in_stance(robot_, q) ? 0 : 1;
    Simulation::Parameters parameters;
    parameters.start = engage(robot_, world.site("start"), q);
    Simulation simulation(robot_, world, Simulation::On::sim, parameters);
    Session& session = simulation.session();
    double first_jump = -1.0;
    double fastest = 0.0;
    Hooks hooks;
    hooks.tick = [&](const TickRecord& record) {
      if (first_jump < 0.0) first_jump = (record.target.q - record.measurement.q).cwiseAbs().maxCoeff();
      if (record.t < 0.1) fastest = std::max(fastest, record.truth->dq.tail(n_).cwiseAbs().maxCoeff());
    };
    session.add(hooks);
    Command home;
    home.recall = Recall::home;
    while (session.t() < 10.0 && !session.fallen())
      session.step(home);
    EXPECT_FALSE(session.fallen()) << simulation.truth().fall;
    EXPECT_LT(first_jump, 1e-3);
    EXPECT_LT(fastest, 0.5);
    EXPECT_TRUE(session.resting());
    EXPECT_TRUE(in_stance(robot_, simulation.truth().q.tail(n_))) << run;
  }
  EXPECT_GT(elsewhere, 3);
}

// Near the stance the plan begins in the stance itself: the joints come to it, they do not jump.
TEST_P(EngageTest, NearItsStanceNoJointJumpsEither) {
  const World world = World::load("flat");
  const VecX stance = stand(robot_, Pose{}, height_).q.tail(n_);
  for (const double direction : {-1.0, 1.0}) {
    Posture there = stand(robot_, world.site("start"), height_);
    for (int k = 1; k < 20; ++k) {  // as far off as is near
      const Posture farther = stand(robot_, world.site("start"), height_ * (1.0 + 0.001 * direction * k));
      if (!in_stance(robot_, farther.q.tail(n_))) break;
      there = farther;
    }
    const double off = (there.q.tail(n_) - stance).cwiseAbs().maxCoeff();
    ASSERT_GT(off, 0.05);
    const double period = robot_.profile().tick.period;
    Simulation::Parameters parameters;
    parameters.start = engage(robot_, world.site("start"), there.q.tail(n_));
    ASSERT_LT((parameters.start->q.tail(n_) - stance).norm(), 1e-9);
    Simulation simulation(robot_, world, std::make_unique<SimulatedRobot>(robot_, world, there, period), parameters);
    Session& session = simulation.session();
    TargetCheck check(robot_);
    VecX before = there.q.tail(n_);
    check.begin(before);
    double step = 0.0;
    double left = 0.0;  // of the way to the plan
    double fastest = 0.0;
    std::string rejected;
    Hooks hooks;
    hooks.tick = [&](const TickRecord& record) {
      const VecX now = commanded(record.target);
      const Target sent{0, now, record.target.dq, record.target.tau};
      rejected = check.reject(sent, record.measurement.q).value_or(rejected);
      step = std::max(step, (now - before).cwiseAbs().maxCoeff());
      before = now;
      left = (now - record.target.q).cwiseAbs().maxCoeff();
      fastest = std::max(fastest, record.truth->dq.tail(n_).cwiseAbs().maxCoeff());
    };
    session.add(hooks);
    Command ahead;  // with the stick held from the first tick on
    ahead.axes[0] = 1.0;
    double begun = 0.0;
    while (session.t() < 2.0 && !session.fallen() && session.resting()) {
      begun = session.t();
      session.step(ahead);
    }
    EXPECT_GT(begun, 1.8 * off / 0.3);
    EXPECT_LT(left, 0.02) << "when a motion begins";
    EXPECT_FALSE(session.fallen()) << simulation.truth().fall;
    EXPECT_EQ(rejected, "") << off;
    EXPECT_LT(step, 0.02) << off;
    EXPECT_LT(fastest, 0.5) << off;
    EXPECT_LT((simulation.truth().q.tail(n_) - stance).cwiseAbs().maxCoeff(), 0.03);
  }
}

TEST_P(EngageTest, ARobotThatDoesNotStandIsNotDriven) {
  const VecX stance = stand(robot_, Pose{}, height_).q.tail(n_);
  const int knee = robot_.leg(Side::left)[3];
  VecX one_bent = stance;
  one_bent[knee] += 0.3;
  EXPECT_THAT(refusal(one_bent), HasSubstr("one sole is inclined"));
  VecX leaning = stance;
  for (const Side side : kSides)
    leaning[robot_.leg(side)[4]] += 0.35;  // both ankles alike
  EXPECT_THAT(refusal(leaning), HasSubstr("would tip over"));
}

}  // namespace
}  // namespace baton::link
