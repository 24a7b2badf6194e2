/// Convex polygons in the horizontal plane: support polygons, soles, ground faces.
#pragma once

#include <span>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// A convex polygon with counter-clockwise vertices. Empty if it has fewer than three.
class ConvexPolygon {
 public:
  ConvexPolygon() = default;

  /// Convex hull of the points [m]; collinear points are dropped.
  [[nodiscard]] static ConvexPolygon hull(std::span<const Vec2> points);

  [[nodiscard]] const std::vector<Vec2>& vertices() const& { return vertices_; }
  [[nodiscard]] std::vector<Vec2> vertices() && { return std::move(vertices_); }
  [[nodiscard]] bool empty() const { return vertices_.size() < 3; }

  /// Least signed distance to the lines through the edges [m]: positive inside, negative outside, −∞ if empty.
  [[nodiscard]] double margin(const Vec2& point) const;

  /// The polygon with every edge moved inward by `margin` [m], or outward if that is negative. Empty if nothing is
  /// left.
  [[nodiscard]] ConvexPolygon inset(double margin) const;

  /// The point of the polygon nearest to `point`; `point` itself if the polygon is empty.
  [[nodiscard]] Vec2 nearest(const Vec2& point) const;

  /// The intersection with `other`.
  [[nodiscard]] ConvexPolygon clipped(const ConvexPolygon& other) const;

  /// Mean of the vertices (the centre of a rectangle).
  [[nodiscard]] Vec2 centre() const;

 private:
  std::vector<Vec2> vertices_;
};

/// Largest gap along an edge normal of either polygon [m]; negative if they overlap. A lower bound on the distance, so
/// conservative as a clearance.
[[nodiscard]] double separation(const ConvexPolygon& a, const ConvexPolygon& b);

}  // namespace baton
