#include "baton/motion/arm_path.hpp"

#include <algorithm>

namespace baton {

double ArmPath::at(Eigen::Index row, double t, double T) const {
  const double last = period * static_cast<double>(q.cols() - 1);
  const double brakes_at = std::clamp(std::min({T - braking, until[row], last}), 0.0, std::max(T, 0.0));
  const double moves = std::clamp(t, 0.0, brakes_at);
  const auto column = static_cast<Eigen::Index>(moves / period + 1e-9);
  const double since = moves - period * static_cast<double>(column);
  const double a = ddq(row, column);
  const double v = dq(row, column) + since * a;
  const double x = q(row, column) + since * (dq(row, column) + 0.5 * since * a);
  const double brakes = std::min(braking, T - brakes_at);
  if (t <= brakes_at || brakes <= 0.0) return x;
  const double s = std::min((t - brakes_at) / brakes, 1.0);
  const double s2 = s * s;
  return x + v * brakes * s * (1.0 - s2 + 0.5 * s2 * s) + a * brakes * brakes * s2 * (0.5 - s * (2.0 / 3.0 - 0.25 * s));
}

}  // namespace baton
