#include "baton/math/polygon.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace baton {
namespace {

class PolygonTest : public testing::Test {
 protected:
  double real(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  Vec2 point(double size = 1.0) { return {real(-size, size), real(-size, size)}; }
  std::vector<Vec2> points() {
    const Vec2 about = point();
    std::vector<Vec2> some;
    for (int n = std::uniform_int_distribution<int>(3, 12)(random_); n > 0; --n)
      some.push_back(about + point());
    return some;
  }
  ConvexPolygon polygon() { return ConvexPolygon::hull(points()); }
  /// Somewhere in a polygon.
  Vec2 inside(const ConvexPolygon& polygon) {
    Vec2 sum = Vec2::Zero();
    double weights = 0.0;
    for (const Vec2& vertex : polygon.vertices()) {
      const double weight = -std::log(real(1e-9, 1.0));
      sum += weight * vertex;
      weights += weight;
    }
    return sum / weights;
  }
  std::mt19937_64 random_{11};
};

double side_of_line(const Vec2& a, const Vec2& b, const Vec2& p) {
  return ((b - a).x() * (p - a).y() - (b - a).y() * (p - a).x()) / (b - a).norm();
}

/// Distance from a point to the rim, by dense sampling.
double distance_to_rim(const ConvexPolygon& polygon, const Vec2& p) {
  double least = std::numeric_limits<double>::infinity();
  const auto& v = polygon.vertices();
  for (std::size_t i = 0; i < v.size(); ++i) {
    for (int k = 0; k < 400; ++k)
      least = std::min(least, (v[i] + (v[(i + 1) % v.size()] - v[i]) * (k / 400.0) - p).norm());
  }
  return least;
}

TEST_F(PolygonTest, HullHoldsAllPointsAndTurnsLeft) {
  for (int trial = 0; trial < 3000; ++trial) {
    const std::vector<Vec2> some = points();
    const ConvexPolygon hull = ConvexPolygon::hull(some);
    const auto& v = hull.vertices();
    ASSERT_FALSE(hull.empty());
    for (std::size_t i = 0; i < v.size(); ++i) {
      ASSERT_TRUE(std::find(some.begin(), some.end(), v[i]) != some.end());
      ASSERT_GT(side_of_line(v[i], v[(i + 1) % v.size()], v[(i + 2) % v.size()]), 0.0);
      for (const Vec2& p : some)
        ASSERT_GE(side_of_line(v[i], v[(i + 1) % v.size()], p), -1e-9);
    }
  }
}

TEST_F(PolygonTest, DegeneratePointsMakeAnEmptyPolygon) {
  const std::vector<Vec2> none;
  const std::vector<Vec2> twice{{1, 2}, {1, 2}, {1, 2}};
  const std::vector<Vec2> line{{0, 0}, {1, 1}, {2, 2}, {0.5, 0.5}};
  for (const auto& some : {none, twice, line}) {
    const ConvexPolygon polygon = ConvexPolygon::hull(some);
    EXPECT_TRUE(polygon.empty());
    EXPECT_EQ(polygon.margin({0, 0}), -std::numeric_limits<double>::infinity());
    EXPECT_EQ(polygon.nearest({3, 4}), Vec2(3, 4));
    EXPECT_TRUE(polygon.inset(0.1).empty());
  }
  const std::vector<Vec2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {1, 1}};
  EXPECT_EQ(ConvexPolygon::hull(square).vertices().size(), 4u);
  EXPECT_LT((ConvexPolygon::hull(square).centre() - Vec2(0.5, 0.5)).norm(), 1e-12);
}

TEST_F(PolygonTest, MarginIsTheDistanceToTheRimInsideAndNoMoreOutside) {
  for (int trial = 0; trial < 1000; ++trial) {
    const ConvexPolygon shape = polygon();
    const Vec2 in = inside(shape);
    ASSERT_GE(shape.margin(in), 0.0);
    ASSERT_NEAR(shape.margin(in), distance_to_rim(shape, in), 0.01);
    const Vec2 p = point(3.0);
    if (shape.margin(p) < 0) {
      ASSERT_LE(-shape.margin(p), distance_to_rim(shape, p) + 1e-9);
    }
  }
}

TEST_F(PolygonTest, InsetHoldsThePointsDeepEnough) {
  for (int trial = 0; trial < 1000; ++trial) {
    const ConvexPolygon shape = polygon();
    const double depth = real(0.0, 0.6);
    const ConvexPolygon inner = shape.inset(depth);
    for (const Vec2& vertex : inner.vertices())
      ASSERT_GE(shape.margin(vertex), depth - 1e-9);
    for (int k = 0; k < 30; ++k) {
      const Vec2 p = inside(shape);
      if (shape.margin(p) > depth + 1e-5) {
        ASSERT_GE(inner.margin(p), -1e-9);
      }
      if (shape.margin(p) < depth - 1e-9) {
        ASSERT_LT(inner.margin(p), 0.0);
      }
    }
  }
}

TEST_F(PolygonTest, NearestIsNearerThanAnyOther) {
  for (int trial = 0; trial < 1000; ++trial) {
    const ConvexPolygon shape = polygon();
    const Vec2 p = point(3.0);
    const Vec2 nearest = shape.nearest(p);
    ASSERT_GE(shape.margin(nearest), -1e-9);
    if (shape.margin(p) >= 0) {
      ASSERT_EQ(nearest, p);
      continue;
    }
    ASSERT_NEAR((nearest - p).norm(), distance_to_rim(shape, p), 0.01);
    for (int k = 0; k < 50; ++k)
      ASSERT_LE((nearest - p).norm(), (inside(shape) - p).norm() + 1e-9);
  }
}

TEST_F(PolygonTest, ClippedIsWhatBothShare) {
  int some = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const ConvexPolygon a = polygon();
    const ConvexPolygon b = polygon();
    const ConvexPolygon both = a.clipped(b);
    for (const Vec2& vertex : both.vertices())
      ASSERT_GE(std::min(a.margin(vertex), b.margin(vertex)), -1e-9);
    some += both.empty() ? 0 : 1;
    for (int k = 0; k < 50; ++k) {
      const Vec2 p = inside(a);
      const double depth = std::min(a.margin(p), b.margin(p));
      if (depth > 1e-5) {
        ASSERT_GE(both.margin(p), -1e-9);
      }
      if (depth < -1e-9) {
        ASSERT_LT(both.margin(p), 0.0);
      }
    }
  }
  EXPECT_GT(some, 300);
  EXPECT_TRUE(polygon().clipped({}).empty());
  EXPECT_TRUE(ConvexPolygon().clipped(polygon()).empty());
}

TEST_F(PolygonTest, SeparationIsNegativeForOverlapAndNeverMoreThanTheDistance) {
  int apart = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const ConvexPolygon a = polygon();
    std::vector<Vec2> moved = polygon().vertices();
    const Vec2 shift = point(3.0);
    for (Vec2& p : moved)
      p += shift;
    const ConvexPolygon b = ConvexPolygon::hull(moved);
    const double gap = separation(a, b);
    ASSERT_EQ(gap, separation(b, a));
    // The true distance is at a vertex of one of them.
    double distance = std::numeric_limits<double>::infinity();
    for (const Vec2& p : a.vertices())
      distance = std::min(distance, (b.nearest(p) - p).norm());
    for (const Vec2& p : b.vertices())
      distance = std::min(distance, (a.nearest(p) - p).norm());
    const bool overlap = !a.clipped(b).empty();
    if (overlap) {
      ASSERT_LT(gap, 1e-5);
    } else {
      ASSERT_GT(gap, -1e-5);
      ASSERT_LE(gap, distance + 1e-9);
      ++apart;
    }
  }
  EXPECT_GT(apart, 100);
}

}  // namespace
}  // namespace baton
