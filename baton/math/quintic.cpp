#include "baton/math/quintic.hpp"

#include <algorithm>

namespace baton {

Quintic::Quintic(const Jet& start, const Jet& end, double duration) : duration_(duration) {
  const double T = duration;
  const double T2 = T * T;
  const double dx = end.x - start.x - start.dx * T - 0.5 * start.ddx * T2;
  const double dv = (end.dx - start.dx - start.ddx * T) * T;
  const double da = (end.ddx - start.ddx) * T2;
  c_ = {start.x,
        start.dx,
        0.5 * start.ddx,
        (10.0 * dx - 4.0 * dv + 0.5 * da) / (T2 * T),
        (-15.0 * dx + 7.0 * dv - da) / (T2 * T2),
        (6.0 * dx - 3.0 * dv + 0.5 * da) / (T2 * T2 * T)};
}

Jet Quintic::at(double t) const {
  t = std::clamp(t, 0.0, duration_);
  Jet jet;
  for (int i = 5; i >= 0; --i) {
    jet.ddx = jet.ddx * t + 2.0 * jet.dx;
    jet.dx = jet.dx * t + jet.x;
    jet.x = jet.x * t + c_[static_cast<std::size_t>(i)];
  }
  return jet;
}

Jet smooth_step(double t, double duration) {
  if (duration <= 0.0 || t >= duration) return {1.0, 0.0, 0.0};
  const double s = std::max(t / duration, 0.0);
  return {s * s * s * (10.0 + s * (-15.0 + 6.0 * s)), 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration,
          60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration)};
}

Carry carry(double t, double duration) {
  if (duration <= 0.0 || t >= duration) return {};
  const double s = std::max(t / duration, 0.0);
  const double decay = (1.0 - s) * (1.0 - s) * (1.0 - s);
  return {duration * s * decay * (1.0 + 3.0 * s), 0.5 * duration * duration * s * s * decay};
}

}  // namespace baton
