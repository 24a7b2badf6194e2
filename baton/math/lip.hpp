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
  Vec3 v = Vec3::Zero();    ///< VRP of the whole body [m]
};

/// Wish for one VRP knot.
struct VrpKnot {
  double t = 0.0;            ///< when
  Vec3 wish = Vec3::Zero();  ///< reference value [m]
  double weight = 1.0;       ///< of the deviation from the wish, > 0
};

/// How far the VRP of the whole body lies from that of its point mass, piecewise linear in time: the limbs' angular
/// momentum (docs/theory.md §3). Empty: a point mass.
struct VrpOffset {
  std::vector<double> times;  ///< [s], increasing from 0
  std::vector<Vec3> values;   ///< [m]

  [[nodiscard]] Vec3 at(double t) const;
};

/// A centre-of-mass motion: knots of the VRP and the state at t = 0.
class ComPath {
 public:
  ComPath() = default;

  /// @param omega [rad/s]
  /// @param times knot times [s], increasing from 0
  /// @param knots VRP at those times [m]; the COM is driven by the VRP less `offset`
  ComPath(double omega, std::vector<double> times, std::vector<Vec3> knots, const Vec3& p0, const Vec3& dp0,
          const VrpOffset& offset = {});

  [[nodiscard]] ComState at(double t) const;
  [[nodiscard]] double duration() const { return times_.empty() ? 0.0 : times_.back(); }
  [[nodiscard]] double omega() const { return omega_; }
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] const std::vector<Vec3>& knots() const { return knots_; }

 private:
  /// Where the VRP or its offset has a corner.
  struct Node {
    double t = 0.0;
    Vec3 v = Vec3::Zero();      ///< VRP
    Vec3 drive = Vec3::Zero();  ///< VRP less offset
    Vec3 p = Vec3::Zero();      ///< COM
    Vec3 dp = Vec3::Zero();
  };
  [[nodiscard]] ComState between(const Node& a, const Node& b, double t) const;

  double omega_ = 1.0;
  std::vector<double> times_;
  std::vector<Vec3> knots_;
  std::vector<Node> nodes_;
};

/// How the DCM ξ = p + ṗ/ω and its mirror η = p − ṗ/ω at the knots depend on the knots' VRPs v, for a COM that starts
/// at (p0, dp0) and ends at rest at `goal`: ξ = Ξ v + ξ0 (solved backwards from the goal) and η = H v + η0 (forwards
/// from the start), so that nothing grows. The motion exists where the first ξ is p0 + dp0/ω and the last η is `goal`:
/// two rows on v for each axis (docs/theory.md §3).
struct KnotResponse {
  MatX xi, eta;                                   ///< Ξ, H: n × n
  Eigen::Matrix<double, Eigen::Dynamic, 3> xi0;   ///< n × 3 [m]
  Eigen::Matrix<double, Eigen::Dynamic, 3> eta0;  ///< n × 3 [m]
  Eigen::Matrix<double, 2, Eigen::Dynamic> A;     ///< the two rows: A v = b
  Eigen::Matrix<double, 2, 3> b;
};
/// @param knots at least two, times increasing from 0; the last time is the duration
/// @throws std::invalid_argument fewer than two knots, times that do not increase
[[nodiscard]] KnotResponse knot_response(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                                         const Vec3& goal, const VrpOffset& offset);

/// Boundary value problem (docs/theory.md §3, "boundary condition relaxation"): the knots nearest to their
/// wishes, in the weighted least-squares sense, that bring the COM from (p0, dp0) to rest at `goal`.
/// @throws std::invalid_argument as above, or weights not positive
[[nodiscard]] std::vector<Vec3> nearest_knots(std::span<const VrpKnot> knots, const KnotResponse& response);
[[nodiscard]] ComPath solve_com_path(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                                     const Vec3& goal);

/// Where the line of force of a point mass at `com` with VRP `v` meets the plane z = `z_ground` [m].
/// Not finite when the vertical force is not positive.
[[nodiscard]] Vec2 zmp_of_vrp(const Vec3& com, const Vec3& v, double z_ground, double omega);

}  // namespace baton
