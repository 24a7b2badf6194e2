#include "baton/plan/com_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "tests/support/random.hpp"

namespace baton {
namespace {

using test::Random;

constexpr double kPeriod = 0.005;
const double kOmega = std::sqrt(9.81 / 0.26);

ConvexPolygon rectangle(const Vec2& low, const Vec2& high) {
  const std::vector<Vec2> corners{low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  return ConvexPolygon::hull(corners);
}

Timing timing_of(const ComProblem& problem, int ticks) {
  return timing_by_shares(problem.phases, ticks, kPeriod);
}

/// A segment of one to three phases, from any moving start to any goal nearby; knots at the borders, and
/// sometimes within a phase.
ComProblem random_problem(Random& random) {
  ComProblem problem;
  problem.omega = random(3.0, 7.0);
  problem.p0 = random.vector(0.1) + Vec3(0, 0, 0.3);
  problem.dp0 = random.vector(0.4);
  problem.goal = problem.p0 + random.vector(0.06);
  const int phases = random.integer(1, 3);
  std::vector<double> shares;
  for (int i = 0; i < phases; ++i)
    shares.push_back(random(0.1, 1.0));
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  double place = 0.0;
  const auto knot = [&](double at) {
    problem.knots.push_back({at, problem.p0 + random.vector(0.1), random(0.2, 5.0)});
  };
  knot(0.0);
  for (const double share : shares) {
    problem.phases.push_back({share / sum, rectangle({-0.3, -0.3}, {0.3, 0.3})});
    if (random.integer(0, 1) == 1) knot(place + 0.5);
    knot(place += 1.0);
  }
  return problem;
}

TEST(ComPlan, MeetsItsBoundaryConditionsAndTheEquationOfMotion) {
  Random random(1);
  for (int trial = 0; trial < 3000; ++trial) {
    const ComProblem problem = random_problem(random);
    const int ticks = random.integer(60, 400);
    const ComPath path = com_path(problem, timing_of(problem, ticks));
    const double T = path.duration();
    ASSERT_NEAR(T, ticks * kPeriod, 1e-12);
    const ComState start = path.at(0.0);
    ASSERT_LT((start.p - problem.p0).norm(), 1e-12);
    ASSERT_LT((start.dp - problem.dp0).norm(), 1e-12);
    // The free motion grows by e^{ωT}, and rounding with it.
    const double rounding = 1e-14 * std::exp(problem.omega * T) + 1e-9;
    const ComState end = path.at(T);
    ASSERT_LT((end.p - problem.goal).norm(), rounding) << "T = " << T;
    ASSERT_LT(end.dp.norm(), 10.0 * rounding);

    for (std::size_t k = 1; k + 1 < path.times().size(); ++k) {  // continuous across the knots
      const double e = 1e-9;
      const ComState before = path.at(path.times()[k] - e);
      const ComState after = path.at(path.times()[k] + e);
      ASSERT_LT((after.p - before.p - 2 * e * before.dp).norm(), 1e-9);
      ASSERT_LT((after.dp - before.dp).norm(), 1e-6);
      ASSERT_LT((path.at(path.times()[k]).v - path.knots()[k]).norm(), 1e-12);
    }
    const double h = 1e-4;
    for (int k = 0; k < 8; ++k) {
      const double t = random(2 * h, T - 2 * h);
      const bool at_knot =
          std::any_of(path.times().begin(), path.times().end(), [&](double at) { return std::abs(at - t) < 2 * h; });
      if (at_knot) continue;
      const ComState x = path.at(t);
      const ComState before = path.at(t - h);
      const ComState after = path.at(t + h);
      ASSERT_LT((x.ddp - problem.omega * problem.omega * (x.p - x.v)).norm(), 1e-9);
      ASSERT_LT(((after.p - before.p) / (2 * h) - x.dp).norm(), 1e-5);
      ASSERT_LT(((after.dp - before.dp) / (2 * h) - x.ddp).norm(), 1e-5);
    }
  }
}

double cost(const std::vector<VrpKnot>& wishes, const std::vector<Vec3>& knots) {
  double sum = 0.0;
  for (std::size_t k = 0; k < knots.size(); ++k)
    sum += wishes[k].weight * (knots[k] - wishes[k].wish).squaredNorm();
  return sum;
}

TEST(ComPlan, KnotsAreTheNearestToTheirWishesThatReachTheGoal) {
  Random random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    ComProblem problem = random_problem(random);
    const int ticks = random.integer(60, 200);
    const ComPath path = com_path(problem, timing_of(problem, ticks));
    const std::size_t n = path.knots().size();
    // The two boundary rows by superposition: what a unit change of each knot does to the end.
    const auto ends = [&](const std::vector<Vec3>& knots) -> Eigen::Vector2d {
      const ComState end = ComPath(problem.omega, path.times(), knots, Vec3::Zero(), Vec3::Zero()).at(path.duration());
      return Eigen::Vector2d(end.p.x(), end.dp.x() / problem.omega) * std::exp(-problem.omega * path.duration());
    };
    MatX rows(2, static_cast<Eigen::Index>(n));
    for (std::size_t k = 0; k < n; ++k) {
      std::vector<Vec3> unit(n, Vec3::Zero());
      unit[k] = Vec3::UnitX();
      rows.col(static_cast<Eigen::Index>(k)) = ends(unit);
    }
    const MatX null = Eigen::FullPivLU<MatX>(rows).kernel();
    if (n < 3) continue;
    const double least = cost(problem.knots, path.knots());
    for (int k = 0; k < 10; ++k) {
      std::vector<Vec3> other = path.knots();
      const VecX step = null * VecX::NullaryExpr(null.cols(), [&] { return random(-1e-3, 1e-3); });
      const Vec3 direction = random.vector(1.0).normalized();
      for (std::size_t i = 0; i < n; ++i)
        other[i] += step[static_cast<Eigen::Index>(i)] * direction;
      ASSERT_GE(cost(problem.knots, other), least - 1e-13);
    }
  }
}

TEST(ComPlan, AHeavierWishIsHeldBetter) {
  Random random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    ComProblem problem = random_problem(random);
    if (problem.knots.size() < 3) continue;
    const auto k = static_cast<std::size_t>(random.integer(0, static_cast<int>(problem.knots.size()) - 1));
    const auto miss = [&] {
      return (com_path(problem, timing_of(problem, 120)).knots()[k] - problem.knots[k].wish).norm();
    };
    const double before = miss();
    problem.knots[k].weight *= 10.0;
    ASSERT_LE(miss(), before + 1e-12);
  }
}

TEST(ComPlan, RefusesProblemsThatAreNone) {
  const Vec3 o = Vec3::Zero();
  const std::vector<VrpKnot> one{{0.0, o, 1.0}};
  const std::vector<VrpKnot> backward{{0.0, o, 1.0}, {0.5, o, 1.0}, {0.4, o, 1.0}};
  const std::vector<VrpKnot> weightless{{0.0, o, 1.0}, {0.5, o, 0.0}};
  EXPECT_THROW((void)solve_com_path(kOmega, one, o, o, o), std::invalid_argument);
  EXPECT_THROW((void)solve_com_path(kOmega, backward, o, o, o), std::invalid_argument);
  EXPECT_THROW((void)solve_com_path(kOmega, weightless, o, o, o), std::invalid_argument);
}

TEST(ComPlan, TheZmpIsWhereTheLineOfForceMeetsThePlane) {
  Random random(4);
  for (int trial = 0; trial < 3000; ++trial) {
    const double omega = random(3.0, 7.0);
    const double plane = random(-0.1, 0.1);
    const Vec3 p = random.vector(0.2) + Vec3(0, 0, 0.5);
    const Vec3 v = p + random.vector(0.15);
    const Vec3 force = omega * omega * (p - v) + Vec3(0, 0, kGravity);  // per mass
    const Vec2 zmp = zmp_of_vrp(p, v, plane, omega);
    if (force.z() <= 0.0) {
      ASSERT_FALSE(zmp.allFinite());
      continue;
    }
    const Vec3 lever = p - Vec3(zmp.x(), zmp.y(), plane);
    ASSERT_LT(lever.cross(force).norm(), 1e-9 * force.norm());
  }
  EXPECT_FALSE(zmp_of_vrp({0, 0, 0.3}, {0, 0, 0.3 + kGravity / 36.0 + 1e-9}, 0.0, 6.0).allFinite());
}

TEST(ComPlan, PhaseBordersFillTheDuration) {
  Random random(5);
  for (int trial = 0; trial < 5000; ++trial) {
    std::vector<SupportPhase> phases(static_cast<std::size_t>(random.integer(1, 5)));
    double sum = 0.0;
    for (SupportPhase& phase : phases)
      sum += phase.share = std::pow(random(0.05, 1.0), 4.0);
    for (SupportPhase& phase : phases)
      phase.share /= sum;
    const int ticks = random.integer(static_cast<int>(phases.size()), 300);
    const std::vector<int> borders = timing_by_shares(phases, ticks, kPeriod).border;
    ASSERT_EQ(borders.size(), phases.size() + 1);
    ASSERT_EQ(borders.front(), 0);
    ASSERT_EQ(borders.back(), ticks);
    double share = 0.0;
    for (std::size_t i = 0; i < phases.size(); ++i) {
      ASSERT_GE(borders[i + 1] - borders[i], 1);
      share += phases[i].share;
      ASSERT_LE(std::abs(borders[i + 1] - share * ticks), static_cast<double>(phases.size()));
    }
  }
}

/// One step in y, docs/theory.md §7: the left foot stands, the right one goes from `right` to `landing`.
ComProblem step_problem(double left, double right, double landing, double height = 0.26) {
  const auto soles = [](double a, double b) {
    return rectangle({-0.05, std::min(a, b) - 0.036}, {0.05, std::max(a, b) + 0.036});
  };
  ComProblem problem;
  problem.omega = kOmega;
  problem.p0 = {0, 0.5 * (left + right), height};
  problem.goal = {0, 0.5 * (left + landing), height};
  problem.phases = {{0.20, soles(left, right)}, {0.36, soles(left, left)}, {0.44, soles(left, landing)}};
  const Vec3 stance(0, left, height);
  problem.knots = {{0.0, problem.p0, 1.0}, {1.0, stance, 1.0}, {2.0, stance, 1.0}, {3.0, problem.goal, 1.0}};
  return problem;
}

void expect_knots(const ComPath& path, const std::array<double, 4>& y) {
  ASSERT_EQ(path.knots().size(), 4u);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(path.knots()[k].y(), y[k], 1e-3) << "knot " << k;
}

TEST(ComPlan, GivesTheNumbersOfTheTheory) {
  const ComPlan first = correct_duration(step_problem(0.042, -0.042, -0.072), 0.5, 0.1, 3.0, kPeriod);
  ASSERT_TRUE(first.feasible);
  EXPECT_EQ(first.timing.ticks(), 100);
  EXPECT_EQ(first.tried, 1);
  expect_knots(first.path, {-0.0160, 0.0122, 0.0078, -0.0418});

  const ComProblem second = step_problem(0.042, -0.072, -0.102);
  const ComPath hasty = com_path(second, timing_of(second, 100));
  expect_knots(hasty, {-0.0384, -0.0007, -0.0018, -0.0617});
  EXPECT_LT(zmp_margin(second, hasty, timing_of(second, 100)).margin, -0.006);
  const ComPlan corrected = correct_duration(second, 0.5, 0.1, 3.0, kPeriod);
  ASSERT_TRUE(corrected.feasible);
  EXPECT_EQ(corrected.timing.ticks(), 200);
  EXPECT_EQ(corrected.tried, 6);
  expect_knots(corrected.path, {-0.0468, 0.0068, 0.0215, -0.0563});
}

TEST(ComPlan, TheMarginIsTheLeastOfADenseSearch) {
  Random random(6);
  for (int trial = 0; trial < 300; ++trial) {
    ComProblem problem = step_problem(0.042, -random(0.04, 0.08), -random(0.04, 0.10));
    problem.goal.x() += random(-0.03, 0.03);
    problem.dp0 = Vec3(random(-0.1, 0.1), random(-0.1, 0.1), 0.0);
    if (trial % 2 == 0) {  // in one support a fast start is what counts
      problem.phases = {{1.0, rectangle({-0.05, -0.10}, {0.05, 0.08})}};
      problem.dp0 *= 4.0;
    }
    const int ticks = random.integer(80, 300);
    const ComPath path = com_path(problem, timing_of(problem, ticks));
    const std::vector<int> borders = timing_of(problem, ticks).border;
    const ZmpMargin found = zmp_margin(problem, path, timing_of(problem, ticks));
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < problem.phases.size(); ++i) {
      const double from = borders[i] * kPeriod;
      const double to = borders[i + 1] * kPeriod;
      for (int k = 0; k <= 500; ++k) {
        const ComState com = path.at(from + (to - from) * k / 500.0);
        least = std::min(least, problem.phases[i].support.margin(zmp_of_vrp(com.p, com.v, 0.0, kOmega)));
      }
    }
    ASSERT_NEAR(found.margin, least, 1e-4);
    ASSERT_GE(found.margin, least - 1e-9);
  }
}

TEST(ComPlan, BoundedKnotsKeepTheZmpInsideAndAreTheNearestThatDo) {
  Random random(8);
  BoundedCom bounded;
  int free = 0;
  int active = 0;
  int infeasible = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    ComProblem problem = step_problem(0.042, -random(0.04, 0.08), -random(0.04, 0.10), random(0.24, 0.28));
    problem.knots.insert(problem.knots.begin() + 1, {0.5, problem.p0, 1.0});
    problem.knots.insert(problem.knots.end() - 1, {2.5, problem.goal, 1.0});
    problem.goal.x() += random(-0.03, 0.03);
    problem.dp0 = Vec3(random(-0.05, 0.05), random(-0.05, 0.05), 0.0);
    problem.margin = random(0.0, 0.015);
    const Timing timing = timing_of(problem, random.integer(60, 300));
    const ComPath unbounded = com_path(problem, timing);
    const std::optional<ComPath> path = bounded.path(problem, timing);
    if (zmp_margin(problem, unbounded, timing).margin >= problem.margin) {
      ++free;
      ASSERT_TRUE(path.has_value());
      for (std::size_t k = 0; k < path->knots().size(); ++k)
        ASSERT_LT((path->knots()[k] - unbounded.knots()[k]).norm(), 1e-9);
    }
    if (!path) {
      ++infeasible;
      continue;
    }
    active += path->knots() == unbounded.knots() ? 0 : 1;
    ASSERT_GE(zmp_margin(problem, *path, timing).margin, problem.margin);
    ASSERT_LT((path->at(timing.duration()).p - problem.goal).norm(), 1e-6);
    ASSERT_LT(path->at(timing.duration()).dp.norm(), 1e-5);
    ASSERT_LT((path->at(0.0).p - problem.p0).norm(), 1e-12);
    ASSERT_LT((path->at(0.0).dp - problem.dp0).norm(), 1e-12);
  }
  EXPECT_GT(free, 300);
  EXPECT_GT(active, 300);
  EXPECT_GT(infeasible, 50);
}

TEST(ComPlan, AnOffsetDrivesTheComAndLeavesTheKnotsTheWholeBodys) {
  Random random(9);
  BoundedCom bounded;
  for (int trial = 0; trial < 500; ++trial) {
    ComProblem problem = step_problem(0.042, -0.042, -random(0.042, 0.07));
    problem.margin = 0.005;
    problem.knots.insert(problem.knots.begin() + 1, {0.5, problem.p0, 1.0});
    problem.knots.insert(problem.knots.end() - 1, {2.5, problem.goal, 1.0});
    const Timing timing = timing_of(problem, random.integer(180, 300));
    VrpOffset offset;
    const int corners = random.integer(2, 40);
    for (int k = 0; k <= corners; ++k) {
      offset.times.push_back(timing.duration() * k / corners);
      offset.values.emplace_back(random(-0.01, 0.01), random(-0.01, 0.01), 0.0);
    }
    const std::optional<ComPath> path = bounded.path(problem, timing, offset);
    ASSERT_TRUE(path.has_value()) << trial;
    ASSERT_LT((path->at(timing.duration()).p - problem.goal).norm(), 1e-6);
    ASSERT_LT(path->at(timing.duration()).dp.norm(), 1e-5);
    for (int k = 0; k < 20; ++k) {
      const double t = random(0.0, timing.duration());
      const ComState x = path->at(t);
      ASSERT_LT((x.ddp - kOmega * kOmega * (x.p - (x.v - offset.at(t)))).norm(), 1e-9);
    }
    ASSERT_GE(zmp_margin(problem, *path, timing).margin, problem.margin);
  }
}

TEST(ComPlan, TheDurationIsTheFirstThatFits) {
  Random random(7);
  int found = 0;
  int given_up = 0;
  int corrected = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    ComProblem problem = step_problem(0.042, -random(0.04, 0.08), -random(0.04, 0.12));
    problem.margin = random(0.0, 0.03);
    const double last = random(0.8, 3.0);
    const ComPlan plan = correct_duration(problem, 0.5, 0.1, last, kPeriod);
    ASSERT_GE(plan.tried, 1);
    const auto fits = [&](int tries) {
      const int ticks = static_cast<int>(std::lround((0.5 + 0.1 * (tries - 1)) / kPeriod));
      const Timing timing = timing_of(problem, ticks);
      return zmp_margin(problem, com_path(problem, timing), timing).margin >= problem.margin;
    };
    for (int k = 1; k < plan.tried; ++k)
      ASSERT_FALSE(fits(k));
    ASSERT_EQ(plan.feasible, fits(plan.tried));
    ASSERT_EQ(plan.timing.ticks(), static_cast<int>(std::lround((0.5 + 0.1 * (plan.tried - 1)) / kPeriod)));
    ASSERT_LE(plan.timing.ticks() * kPeriod, last + 1e-6);
    if (!plan.feasible) {
      ASSERT_GT(plan.timing.ticks() * kPeriod, last - 0.1 - 1e-6);
    }
    found += plan.feasible ? 1 : 0;
    given_up += plan.feasible ? 0 : 1;
    corrected += plan.feasible && plan.tried > 1 ? 1 : 0;
    // A smaller margin never needs more time.
    problem.margin *= 0.5;
    const ComPlan easier = correct_duration(problem, 0.5, 0.1, last, kPeriod);
    ASSERT_LE(easier.tried, plan.tried);
    ASSERT_TRUE(easier.feasible || !plan.feasible);
  }
  EXPECT_GT(found, 100);
  EXPECT_GT(given_up, 100);
  EXPECT_GT(corrected, 100);
}

}  // namespace
}  // namespace baton
