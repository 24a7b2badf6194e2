/// The three-dimensional linear inverted pendulum p̈ = ω² (p − v), driven by a piecewise linear virtual repellent
/// point (VRP) v: closed form and boundary value problem (docs/theory.md §3).
#pragma once

#include <span>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// State of the centre of mass (COM), and the VRP.
struct ComState {
  Vec3 p = Vec3::Zero();    ///< [m]
  Vec3 dp = Vec3::Zero();   ///< [m/s]
  Vec3 ddp = Vec3::Zero();  ///< [m/s²]
  Vec3 v = Vec3::Zero();    ///< whole-body VRP [m]
};

/// Desired value of one VRP knot.
struct VrpKnot {
  double t = 0.0;            ///< [s]
  Vec3 wish = Vec3::Zero();  ///< desired VRP [m]
  double weight = 1.0;       ///< on the squared deviation from `wish`, > 0
};

/// Whole-body VRP minus point-mass VRP, piecewise linear in time: the effect of the limbs' angular momentum
/// (docs/theory.md §3). Empty: a point mass.
struct VrpOffset {
  std::vector<double> times;  ///< [s], increasing from 0
  std::vector<Vec3> values;   ///< [m]

  [[nodiscard]] Vec3 at(double t) const;
};

/// A COM trajectory: VRP knots, and the state at t = 0.
class ComPath {
 public:
  ComPath() = default;

  /// @param omega [rad/s]
  /// @param times knot times [s], increasing from 0
  /// @param knots VRP at those times [m]
  /// @param offset subtracted from the VRP; the difference drives the COM
  ComPath(double omega, std::vector<double> times, std::vector<Vec3> knots, const Vec3& p0, const Vec3& dp0,
          const VrpOffset& offset = {});

  [[nodiscard]] ComState at(double t) const;
  [[nodiscard]] double duration() const { return times_.empty() ? 0.0 : times_.back(); }
  [[nodiscard]] double omega() const { return omega_; }
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] const std::vector<Vec3>& knots() const { return knots_; }

 private:
  /// Time at which the VRP or its offset changes slope.
  struct Node {
    double t = 0.0;
    Vec3 v = Vec3::Zero();      ///< VRP
    Vec3 drive = Vec3::Zero();  ///< VRP minus offset
    Vec3 p = Vec3::Zero();      ///< COM
    Vec3 dp = Vec3::Zero();
  };
  [[nodiscard]] ComState between(const Node& a, const Node& b, double t) const;

  double omega_ = 1.0;
  std::vector<double> times_;
  std::vector<Vec3> knots_;
  std::vector<Node> nodes_;
};

/// Divergent and convergent components ξ = p + ṗ/ω and η = p − ṗ/ω at the knots, as affine functions of the knots'
/// VRPs v: ξ = Ξ v + ξ0 and η = H v + η0.
///
/// The COM starts at (p0, dp0) and ends at rest at `goal`. ξ is solved backwards from the goal and η forwards from the
/// start, so that both recursions are stable. The boundary conditions are that the first ξ is p0 + dp0/ω and the last η
/// is `goal`: two linear equations in v for each axis (docs/theory.md §3).
struct KnotResponse {
  MatX xi, eta;                                   ///< Ξ, H: n × n
  Eigen::Matrix<double, Eigen::Dynamic, 3> xi0;   ///< n × 3 [m]
  Eigen::Matrix<double, Eigen::Dynamic, 3> eta0;  ///< n × 3 [m]
  Eigen::Matrix<double, 2, Eigen::Dynamic> A;     ///< boundary conditions A v = b
  Eigen::Matrix<double, 2, 3> b;
};
/// @param knots at least two, times increasing from 0; the last time is the duration
/// @throws std::invalid_argument fewer than two knots, times not increasing
[[nodiscard]] KnotResponse knot_response(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                                         const Vec3& goal, const VrpOffset& offset);

/// The knots closest to their wishes, by weighted least squares, that meet the boundary conditions
/// (docs/theory.md §3, "boundary condition relaxation").
/// @throws std::invalid_argument weights not positive
[[nodiscard]] std::vector<Vec3> nearest_knots(std::span<const VrpKnot> knots, const KnotResponse& response);

/// The COM trajectory by `nearest_knots` from (p0, dp0) to rest at `goal`.
/// @throws std::invalid_argument as the two above
[[nodiscard]] ComPath solve_com_path(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                                     const Vec3& goal);

/// ZMP on the plane z = `z_ground` [m] of a point mass at `com` with VRP `v`. NaN unless the vertical force is
/// positive.
[[nodiscard]] Vec2 zmp_of_vrp(const Vec3& com, const Vec3& v, double z_ground, double omega);

}  // namespace baton
