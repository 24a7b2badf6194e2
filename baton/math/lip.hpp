/// The linear inverted pendulum in three dimensions, p̈ = ω² (p − v), driven by a virtual repellent point
/// (VRP) v that is piecewise linear in time: its closed form and its boundary value problem
/// (docs/theory.md §3).
#pragma once

#include <span>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// State of the centre of mass, with the VRP that acts on it.
struct ComState {
  Vec3 p = Vec3::Zero();    ///< [m]
  Vec3 dp = Vec3::Zero();   ///< [m/s]
  Vec3 ddp = Vec3::Zero();  ///< [m/s²]
  Vec3 v = Vec3::Zero();    ///< VRP [m]
};

/// Wish for one VRP knot.
struct VrpKnot {
  double t = 0.0;            ///< [s] from the start
  Vec3 wish = Vec3::Zero();  ///< reference value [m]
  double weight = 1.0;       ///< of the deviation from the wish, > 0
};

/// A centre-of-mass motion: knots of the VRP and the state at t = 0.
class ComPath {
 public:
  ComPath() = default;

  /// @param omega [rad/s]
  /// @param times knot times [s], increasing from 0
  /// @param knots VRP at those times [m]
  ComPath(double omega, std::vector<double> times, std::vector<Vec3> knots, const Vec3& p0, const Vec3& dp0);

  [[nodiscard]] ComState at(double t) const;
  [[nodiscard]] double duration() const { return times_.empty() ? 0.0 : times_.back(); }
  [[nodiscard]] double omega() const { return omega_; }
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] const std::vector<Vec3>& knots() const { return knots_; }

 private:
  double omega_ = 1.0;
  std::vector<double> times_;
  std::vector<Vec3> knots_;
  std::vector<Vec3> p_;   ///< COM at the knots
  std::vector<Vec3> dp_;  ///< and its velocity
};

/// Boundary value problem (docs/theory.md §3, "boundary condition relaxation"): the knots nearest to their
/// wishes, in the weighted least-squares sense, that bring the COM from (p0, dp0) to rest at `goal`.
/// @param knots at least two, times increasing from 0; the last time is the duration
/// @throws std::invalid_argument fewer than two knots, times that do not increase, weights not positive
[[nodiscard]] ComPath solve_com_path(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                                     const Vec3& goal);

/// Where the line of force of a point mass at `com` with VRP `v` meets the plane z = `z_ground` [m].
/// Not finite when the vertical force is not positive.
[[nodiscard]] Vec2 zmp_of_vrp(const Vec3& com, const Vec3& v, double z_ground, double omega);

}  // namespace baton
