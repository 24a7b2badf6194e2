/// Convex polygons in a horizontal plane: support polygons, soles, faces of the ground.
#pragma once

#include <span>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// A convex polygon, vertices counter-clockwise. Empty when it has fewer than three vertices.
class ConvexPolygon {
 public:
  ConvexPolygon() = default;

  /// Convex hull of the points [m]; collinear points are dropped.
  [[nodiscard]] static ConvexPolygon hull(std::span<const Vec2> points);

  [[nodiscard]] const std::vector<Vec2>& vertices() const& { return vertices_; }
  [[nodiscard]] std::vector<Vec2> vertices() && { return std::move(vertices_); }
  [[nodiscard]] bool empty() const { return vertices_.size() < 3; }

  /// Distance to the nearest edge's line [m]: positive inside, negative outside, −∞ when empty.
  [[nodiscard]] double margin(const Vec2& point) const;

  /// The points at least `margin` inside every edge; empty if there are none. A negative margin moves the edges
  /// outward.
  [[nodiscard]] ConvexPolygon inset(double margin) const;

  /// The point of the polygon nearest to `point`; `point` itself when the polygon is empty.
  [[nodiscard]] Vec2 nearest(const Vec2& point) const;

  /// The part of this polygon that lies in `other`.
  [[nodiscard]] ConvexPolygon clipped(const ConvexPolygon& other) const;

  /// Mean of the vertices (the centre of a rectangle).
  [[nodiscard]] Vec2 centre() const;

 private:
  std::vector<Vec2> vertices_;
};

/// Largest gap along an edge normal of either polygon [m]; negative when they overlap. Never more than
/// the true distance, so it is on the safe side as a clearance.
[[nodiscard]] double separation(const ConvexPolygon& a, const ConvexPolygon& b);

}  // namespace baton
