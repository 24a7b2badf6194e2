#include "baton/math/polygon.hpp"

#include <algorithm>
#include <limits>

namespace baton {
namespace {

constexpr double kSameVertex = 1e-9;  ///< vertices closer than this are one [m]

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The part of a vertex loop where normal · x ≥ offset (Sutherland–Hodgman).
std::vector<Vec2> clip_half_plane(const std::vector<Vec2>& loop, const Vec2& normal, double offset) {
  std::vector<Vec2> kept;
  kept.reserve(loop.size() + 1);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2& a = loop[i];
    const Vec2& b = loop[(i + 1) % loop.size()];
    const double da = normal.dot(a) - offset;
    const double db = normal.dot(b) - offset;
    if (da >= 0) kept.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) kept.push_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

/// Inward unit normal of the edge a → b of a counter-clockwise polygon.
Vec2 inward_normal(const Vec2& a, const Vec2& b) {
  const Vec2 edge = (b - a).normalized();
  return {-edge.y(), edge.x()};
}

}  // namespace

ConvexPolygon ConvexPolygon::hull(std::span<const Vec2> points) {
  std::vector<Vec2> sorted(points.begin(), points.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Vec2> chain;
  const auto extend = [&chain](const Vec2& point, std::size_t base) {
    while (chain.size() >= base + 2 && cross(chain.back() - chain[chain.size() - 2], point - chain.back()) <= 0.0) {
      chain.pop_back();
    }
    chain.push_back(point);
  };
  for (const Vec2& point : sorted)
    extend(point, 0);
  const std::size_t lower = chain.size();
  for (std::size_t i = sorted.size(); i-- > 1;)
    extend(sorted[i - 1], lower - 1);
  if (chain.size() > 1) chain.pop_back();
  // Vertices that coincide but for rounding would give edges without a direction.
  std::vector<Vec2> corners;
  for (const Vec2& point : chain) {
    const bool known = std::any_of(corners.begin(), corners.end(), [&](const Vec2& corner) {
      return (corner - point).squaredNorm() < kSameVertex * kSameVertex;
    });
    if (!known) corners.push_back(point);
  }
  ConvexPolygon polygon;
  if (corners.size() >= 3) polygon.vertices_ = std::move(corners);
  return polygon;
}

double ConvexPolygon::margin(const Vec2& point) const {
  if (empty()) return -std::numeric_limits<double>::infinity();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vec2& a = vertices_[i];
    least = std::min(least, inward_normal(a, vertices_[(i + 1) % vertices_.size()]).dot(point - a));
  }
  return least;
}

ConvexPolygon ConvexPolygon::inset(double margin) const {
  if (empty()) return {};
  std::vector<Vec2> loop = vertices_;
  if (margin < 0.0) {  // to grow: clip a box large enough for the result, acute corners included
    Vec2 lo = vertices_.front();
    Vec2 hi = lo;
    for (const Vec2& vertex : vertices_) {
      lo = lo.cwiseMin(vertex);
      hi = hi.cwiseMax(vertex);
    }
    const Vec2 room = Vec2::Constant((hi - lo).norm() - 10.0 * margin);
    lo -= room;
    hi += room;
    loop = {lo, {hi.x(), lo.y()}, hi, {lo.x(), hi.y()}};
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vec2& a = vertices_[i];
    const Vec2 normal = inward_normal(a, vertices_[(i + 1) % vertices_.size()]);
    loop = clip_half_plane(loop, normal, normal.dot(a) + margin);
  }
  return hull(loop);
}

Vec2 ConvexPolygon::nearest(const Vec2& point) const {
  if (empty() || margin(point) >= 0) return point;
  Vec2 best = vertices_.front();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vec2& a = vertices_[i];
    const Vec2 edge = vertices_[(i + 1) % vertices_.size()] - a;
    const Vec2 candidate = a + edge * std::clamp(edge.dot(point - a) / edge.squaredNorm(), 0.0, 1.0);
    if ((candidate - point).squaredNorm() < (best - point).squaredNorm()) best = candidate;
  }
  return best;
}

ConvexPolygon ConvexPolygon::clipped(const ConvexPolygon& other) const {
  if (other.empty()) return {};
  std::vector<Vec2> loop = vertices_;
  for (std::size_t i = 0; i < other.vertices_.size(); ++i) {
    const Vec2& a = other.vertices_[i];
    const Vec2 normal = inward_normal(a, other.vertices_[(i + 1) % other.vertices_.size()]);
    loop = clip_half_plane(loop, normal, normal.dot(a));
  }
  return hull(loop);
}

Vec2 ConvexPolygon::centre() const {
  Vec2 sum = Vec2::Zero();
  for (const Vec2& vertex : vertices_)
    sum += vertex;
  return empty() ? sum : Vec2(sum / static_cast<double>(vertices_.size()));
}

double separation(const ConvexPolygon& a, const ConvexPolygon& b) {
  const auto widest_gap = [](const ConvexPolygon& of, const ConvexPolygon& to) {
    double widest = -std::numeric_limits<double>::infinity();
    const auto& vertices = of.vertices();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec2 outward = -inward_normal(vertices[i], vertices[(i + 1) % vertices.size()]);
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vec2& vertex : to.vertices())
        nearest = std::min(nearest, outward.dot(vertex - vertices[i]));
      widest = std::max(widest, nearest);
    }
    return widest;
  };
  return std::max(widest_gap(a, b), widest_gap(b, a));
}

}  // namespace baton
