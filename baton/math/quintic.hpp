/// Quintic polynomials between given positions, velocities and accelerations.
#pragma once

#include <array>

namespace baton {

/// Value and first two derivatives of a scalar function of time.
struct Jet {
  double x = 0.0;    ///< [m] or [rad] or [-]
  double dx = 0.0;   ///< [·/s]
  double ddx = 0.0;  ///< [·/s²]
};

/// Quintic with given end states. Before the start and after the end it keeps its end state.
class Quintic {
 public:
  /// @param duration [s] > 0
  Quintic(const Jet& start, const Jet& end, double duration);

  [[nodiscard]] Jet at(double t) const;

 private:
  std::array<double, 6> c_{};
  double duration_;
};

/// Rest-to-rest quintic blend of s = t/duration in 0…1: 10 s³ − 15 s⁴ + 6 s⁵, and its time derivatives.
[[nodiscard]] Jet smooth_step(double t, double duration);

/// Basis functions by which an initial velocity v and acceleration a decay along a path blended by `smooth_step`:
/// `velocity`·v + `acceleration`·a is added to the path. Both are zero at both ends, and end at rest (docs/theory.md
/// §9).
struct Carry {
  double velocity = 0.0;      ///< [s]
  double acceleration = 0.0;  ///< [s²]
};
[[nodiscard]] Carry carry(double t, double duration);

}  // namespace baton
