#include "bench/lower_bound.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "baton/plan/shortest.hpp"

namespace baton::bench {
namespace {

constexpr double kPeriod = 0.005;
constexpr double kMargin = 0.012;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double real(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine_); }
  bool chance(double share) { return real(0.0, 1.0) < share; }

 private:
  std::mt19937_64 engine_;
};

std::array<Vec2, 4> sole(const Vec2& centre, double yaw) {
  const Eigen::Rotation2Dd R(yaw);
  return {centre + R * Vec2(-0.05, -0.035), centre + R * Vec2(0.05, -0.035), centre + R * Vec2(0.05, 0.035),
          centre + R * Vec2(-0.05, 0.035)};
}

ConvexPolygon hull(const std::array<Vec2, 4>& a, const std::array<Vec2, 4>& b) {
  std::vector<Vec2> points(a.begin(), a.end());
  points.insert(points.end(), b.begin(), b.end());
  return ConvexPolygon::hull(points);
}

/// From rest to rest on one support, all places of it open to the ZMP in x, an interval in y.
ComProblem shift(double height, double from, double to, double room) {
  ComProblem problem;
  problem.omega = std::sqrt(kGravity / 0.26);
  problem.p0 = {0.1, from, height};
  problem.goal = {0.1, to, height};
  problem.margin = kMargin;
  const double lo = std::min(from, to) - room - kMargin;
  const double hi = std::max(from, to) + room + kMargin;
  const std::vector<Vec2> corners{{-1.0, lo}, {1.0, lo}, {1.0, hi}, {-1.0, hi}};
  problem.phases = {{1.0, ConvexPolygon::hull(corners)}};
  for (int k = 0; k <= 5; ++k)
    problem.knots.push_back({0.2 * k, problem.p0, 1.0});
  return problem;
}

/// A step of the left foot: both, the right one, both.
ComProblem step(Random& random) {
  ComProblem problem;
  const double height = random.real(0.23, 0.29);
  problem.omega = std::sqrt(kGravity / 0.26);
  const auto stance = sole({0, 0}, 0);
  const Vec2 start(random.real(-0.08, 0.08), random.real(0.078, 0.12));
  const Vec2 end(random.real(-0.08, 0.08), random.real(0.078, 0.12));
  const auto before = sole(start, random.real(-0.1, 0.1));
  const auto after = sole(end, random.real(-0.1, 0.1));
  problem.p0 << 0.5 * start, height;
  problem.goal << 0.5 * end, height;
  if (random.chance(0.5)) problem.p0.head<2>() += Vec2(random.real(-0.01, 0.01), random.real(-0.02, 0.02));
  problem.margin = kMargin;
  problem.phases = {{0.25, hull(before, stance)}, {0.4, ConvexPolygon::hull(stance)}, {0.35, hull(after, stance)}};
  for (const double place : {0.0, 0.7, 1.0, 1.33, 1.67, 2.0, 2.3, 3.0})
    problem.knots.push_back({place, place < 1.0 ? problem.p0 : place > 2.0 ? problem.goal : Vec3(0, 0, height), 1.0});
  return problem;
}

TEST(LowerBound, IsTheClosedFormForAShiftWithRoomAtBothEnds) {
  Random random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const double height = random.real(0.2, 0.35);
    const double distance = random.real(0.01, 0.08);
    const double room = random.real(0.008, 0.04);
    const bool left = random.chance(0.5);
    const ComProblem problem = shift(height, left ? 0.0 : distance, left ? distance : 0.0, room);
    const double omega = std::sqrt(kGravity / height);
    const double exact = 2.0 * std::acosh(1.0 + 0.5 * distance / room) / omega;
    for (const double period : {kPeriod, 0.001}) {
      const std::optional<int> ticks = least_ticks(problem, std::nullopt, 0, 2000, period);
      ASSERT_TRUE(ticks);
      // The next tick after it; the switch falls between intervals, which may cost one more.
      EXPECT_GE(*ticks * period, exact - 1e-4) << "D " << distance << " r " << room;
      EXPECT_LE(*ticks * period, exact + 1.2 * period) << "D " << distance << " r " << room;
    }
  }
}

TEST(LowerBound, DoesNotDependOnTheGuess) {
  Random random(2);
  for (int trial = 0; trial < 10; ++trial) {
    const ComProblem problem = step(random);
    const std::optional<int> ticks = least_ticks(problem, 1, 40, 600, kPeriod);
    for (const int guess : {1, 60, 600})
      EXPECT_EQ(least_ticks(problem, 1, 40, 600, kPeriod, guess), ticks);
  }
}

TEST(LowerBound, IsNeverAboveWhatAnyDivisionWithKnotsCanDo) {
  Random random(3);
  BoundedCom com;
  for (int trial = 0; trial < 10; ++trial) {
    const ComProblem problem = step(random);
    const std::optional<int> least = least_ticks(problem, 1, 40, 600, kPeriod);
    ASSERT_TRUE(least);
    EXPECT_GE(*least, 42);
    for (int before = 1; before + 41 < *least - 1; ++before) {
      const Timing timing{kPeriod, {0, before, before + 40, *least - 1}};
      EXPECT_FALSE(com.path(problem, timing));
    }
  }
}

TEST(LowerBound, RefusesAComThatChangesItsHeight) {
  ComProblem problem = shift(0.26, 0.0, 0.03, 0.02);
  problem.goal.z() += 0.01;
  EXPECT_THROW((void)least_ticks(problem, std::nullopt, 0, 600, kPeriod), std::invalid_argument);
}

TEST(Shortest, KeepsTheZmpInsideAndTheSwingLongEnough) {
  Random random(4);
  BoundedCom com;
  for (int trial = 0; trial < 300; ++trial) {
    const ComProblem problem = step(random);
    const std::optional<Shortest> shortest = shortest_timing(com, problem, 1, 40, 600, kPeriod);
    ASSERT_TRUE(shortest);
    const std::vector<int>& border = shortest->timing.border;
    ASSERT_EQ(border.size(), 4U);
    EXPECT_GT(border[1], border[0]);
    EXPECT_GE(border[2] - border[1], 40);
    EXPECT_GT(border[3], border[2]);
    EXPECT_GE(zmp_margin(problem, shortest->path, shortest->timing).margin, kMargin);
    const ComState end = shortest->path.at(shortest->timing.duration());
    EXPECT_LT((end.p - problem.goal).norm(), 1e-6);
    EXPECT_LT(end.dp.norm(), 1e-5);
  }
}

TEST(Shortest, ComesNearTheLeast) {
  Random random(5);
  BoundedCom com;
  for (int trial = 0; trial < 60; ++trial) {
    const bool steps = random.chance(0.7);
    const ComProblem problem =
        steps ? step(random) : shift(0.26, 0.0, random.real(0.01, 0.06), random.real(0.015, 0.04));
    const std::optional<std::size_t> swing = steps ? std::optional<std::size_t>(1) : std::nullopt;
    const std::optional<Shortest> shortest = shortest_timing(com, problem, swing, 40, 600, kPeriod);
    ASSERT_TRUE(shortest);
    const std::optional<int> least = least_ticks(problem, swing, 40, 600, kPeriod, shortest->timing.ticks());
    ASSERT_TRUE(least);
    EXPECT_GE(shortest->timing.ticks(), *least);
    EXPECT_LE(shortest->timing.ticks(), 1.5 * *least);
  }
}

TEST(Shortest, FindsNoneWhereThereIsNone) {
  BoundedCom com;
  ComProblem problem = shift(0.26, 0.0, 0.03, 0.02);
  problem.goal.y() = 0.2;  // no rest there
  EXPECT_FALSE(shortest_timing(com, problem, std::nullopt, 0, 200, kPeriod));
}

}  // namespace
}  // namespace baton::bench
