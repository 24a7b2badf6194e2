/// Calibration: the postures that a robot is led through, and what is found from its readings there.
#include "baton/calibrate/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "baton/calibrate/posing.hpp"
#include "baton/model/error.hpp"
#include "baton/robot/plant.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

/// What an exact robot reads at its rests, once a process.
const std::vector<Rest>& exact_rests(const std::string& name) {
  static std::map<std::string, std::vector<Rest>> made;
  std::vector<Rest>& rests = made[name];
  if (!rests.empty()) return rests;
  const RobotModel& robot = test::robot(name);
  const World world = World::load("flat");
  Simulation simulation(robot, world, Simulation::On::ideal, {.session = {.modes = {.gait = Gait::stop}}});
  Posing posing(robot);
  simulation.session().add(posing);
  while (!posing.done() && simulation.session().t() < 100.0)
    simulation.session().step(posing);
  return rests = posing.rests();
}

class CalibrateTest : public testing::TestWithParam<std::string> {
 protected:
  /// A robot with errors as its profile states them, in the postures of the exact one.
  struct Drawn {
    Calibration errors;
    double play = 0.0;
    double yield = 0.0;
    std::vector<Rest> rests;
  };

  [[nodiscard]] Drawn drawn(unsigned seed) const {
    std::mt19937 random(seed);
    const auto even = [&](double bound) { return std::uniform_real_distribution<double>(-bound, bound)(random); };
    const auto normal = [&](double sigma) { return std::normal_distribution<double>(0.0, sigma)(random); };
    const SensorErrors& s = robot_.profile().sensors;
    const double weight = robot_.mass() * kGravity;
    const double height = robot_.profile().stance.com_height;
    Drawn d{.errors = Calibration::none(joints_),
            .play = robot_.profile().actuators.backlash * std::abs(even(1.0)),
            .yield = robot_.profile().actuators.hip_compliance * std::abs(even(1.0)),
            .rests = rests_};
    for (const int j : legs_)
      d.errors.encoder_zero[j] = even(s.encoder_offset);
    const double way = even(M_PI);
    d.errors.imu_mount = s.imu_mount * Vec2(std::cos(way), std::sin(way));
    for (const Side side : kSides) {
      d.errors.force_gain[side] = 1.0 + even(s.force_gain);
      d.errors.force_zero[side] = s.force_zero * weight * Vec3(even(0.1), even(0.1), even(1.0));
    }
    for (Rest& rest : d.rests) {
      Measurement m;
      m.q = rest.q;
      for (Eigen::Index j = 0; j < joints_; ++j) {
        // At the end of the play where the motor pushes, by however little.
        m.q[j] += std::copysign(d.play, rest.torque[j]) + normal(4e-4);
      }
      for (const Side side : kSides) {
        const int hip = abduction(robot_, side);
        m.q[hip] += d.yield * rest.torque[hip] / (weight * height);
      }
      m.imu.acceleration = rest.acceleration + 5e-3 * Vec3(normal(1), normal(1), normal(1));
      m.sole = rest.sole;
      for (const Side side : kSides) {
        m.sole[side].force *= 1.0 + normal(2e-3);
        m.sole[side].moment *= 1.0 + normal(2e-3);
      }
      m = with_errors(m, d.errors);
      rest.q = m.q;
      rest.acceleration = m.imu.acceleration;
      rest.sole = m.sole;
    }
    return d;
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const int joints_ = robot_.nv() - 6;
  const std::vector<int> legs_ = leg_joints(robot_);
  const std::vector<Rest>& rests_ = exact_rests(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Robots, CalibrateTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(CalibrateTest, ItIsLedThroughDistinctPosturesAndRestsInThem) {
  ASSERT_GE(rests_.size(), 20u);
  std::set<int> stances;
  int on_one = 0;
  for (std::size_t i = 0; i < rests_.size(); ++i) {
    stances.insert(rests_[i].stance);
    on_one += rests_[i].contact.left && rests_[i].contact.right ? 0 : 1;
    EXPECT_NEAR(rests_[i].acceleration.norm(), kGravity, 1e-6) << "at rest";
    if (i > 0) {
      EXPECT_GT((rests_[i].q - rests_[i - 1].q).norm(), 0.02);
    }
  }
  EXPECT_EQ(on_one, 2);
  EXPECT_GE(stances.size(), 6u);
}

TEST_P(CalibrateTest, ExactSensorsHaveNoErrors) {
  const Estimate found = estimate(robot_, rests_);
  EXPECT_LT(found.calibration.encoder_zero.norm(), 2e-4);
  EXPECT_LT(found.calibration.imu_mount.norm(), 2e-4);
  for (const Side side : kSides) {
    EXPECT_NEAR(found.calibration.force_gain[side], 1.0, 1e-3);
    EXPECT_LT(found.calibration.force_zero[side].norm(), 1e-3 * robot_.mass() * kGravity);
  }
  EXPECT_LT(found.misfit, 0.2);
}

TEST_P(CalibrateTest, FindsWhatStandingTellsAndKnowsHowWell) {
  double before = 0.0, after = 0.0, mount_before = 0.0, mount_after = 0.0, force_before = 0.0, force_after = 0.0;
  double normalised = 0.0;
  int count = 0;
  constexpr unsigned kCases = 40;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    const Drawn d = drawn(seed);
    const Estimate found = estimate(robot_, d.rests);
    for (const int j : legs_) {
      const double off = found.calibration.encoder_zero[j] - d.errors.encoder_zero[j];
      before += std::pow(d.errors.encoder_zero[j], 2);
      after += off * off;
      normalised += std::pow(off / found.sigma.encoder_zero[j], 2);
      ++count;
      EXPECT_LT(found.sigma.encoder_zero[j], found.prior.encoder_zero[j]);
      EXPECT_LT(std::abs(off), 4.0 * found.sigma.encoder_zero[j]) << robot_.joints()[static_cast<std::size_t>(j)].name;
    }
    mount_before += d.errors.imu_mount.squaredNorm();
    mount_after += (found.calibration.imu_mount - d.errors.imu_mount).squaredNorm();
    for (const Side side : kSides) {
      force_before += d.errors.force_zero[side].squaredNorm();
      force_after += (found.calibration.force_zero[side] - d.errors.force_zero[side]).squaredNorm();
      EXPECT_NEAR(found.calibration.force_gain[side], d.errors.force_gain[side], 4.0 * found.sigma.force_gain[side]);
    }
    EXPECT_NEAR(found.play, d.play, 4.0 * found.play_sigma);
    EXPECT_LT(found.misfit, 1.5);
  }
  EXPECT_LT(after, 0.3 * before) << "rms: 0.55";
  EXPECT_LT(mount_after, 0.1 * mount_before);
  EXPECT_LT(force_after, 0.02 * force_before);
  const double spread = std::sqrt(normalised / count);
  EXPECT_GT(spread, 0.5) << "standard deviations are no excuse";
  EXPECT_LT(spread, 1.1) << "nor a promise";
}

TEST_P(CalibrateTest, DoesNotDependOnTheOrderOfRests) {
  Drawn d = drawn(100);
  const Estimate found = estimate(robot_, d.rests);
  std::reverse(d.rests.begin(), d.rests.end());
  const Estimate again = estimate(robot_, d.rests);
  EXPECT_LT((found.calibration.encoder_zero - again.calibration.encoder_zero).norm(), 1e-5);
  EXPECT_LT((found.calibration.imu_mount - again.calibration.imu_mount).norm(), 1e-5);
}

TEST_P(CalibrateTest, LeavesAloneWhatStandingDoesNotTell) {
  const Estimate found = estimate(robot_, drawn(101).rests);
  for (int j = 0; j < joints_; ++j) {
    if (std::find(legs_.begin(), legs_.end(), j) != legs_.end()) continue;
    EXPECT_EQ(found.calibration.encoder_zero[j], 0.0);
    EXPECT_EQ(found.sigma.encoder_zero[j], found.prior.encoder_zero[j]);
  }
}

TEST_P(CalibrateTest, RefusesReadingsThatAreNone) {
  std::vector<Rest> rests = rests_;
  rests[3].q[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(static_cast<void>(estimate(robot_, rests)), InputError);
}

}  // namespace
}  // namespace baton
