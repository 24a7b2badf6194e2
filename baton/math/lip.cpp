#include "baton/math/lip.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace baton {

ComPath::ComPath(double omega, std::vector<double> times, std::vector<Vec3> knots, const Vec3& p0, const Vec3& dp0)
    : omega_(omega), times_(std::move(times)), knots_(std::move(knots)), p_{p0}, dp_{dp0} {
  p_.reserve(times_.size());
  dp_.reserve(times_.size());
  for (std::size_t k = 1; k < times_.size(); ++k) {
    const ComState end = at(times_[k]);
    p_.push_back(end.p);
    dp_.push_back(end.dp);
  }
}

ComState ComPath::at(double t) const {
  const double clamped = std::clamp(t, 0.0, times_.back());
  // The interval that holds t, among those whose initial state is known.
  std::size_t k = std::min(p_.size(), times_.size() - 1) - 1;
  while (k > 0 && clamped < times_[k])
    --k;
  const double h = times_[k + 1] - times_[k];
  const double tau = clamped - times_[k];
  const Vec3 rate = (knots_[k + 1] - knots_[k]) / h;
  const double c = std::cosh(omega_ * tau);
  const double s = std::sinh(omega_ * tau);
  ComState state;
  state.v = knots_[k] + rate * tau;
  const Vec3 a = p_[k] - knots_[k];
  const Vec3 b = (dp_[k] - rate) / omega_;
  state.p = state.v + a * c + b * s;
  state.dp = rate + omega_ * (a * s + b * c);
  state.ddp = omega_ * omega_ * (state.p - state.v);
  return state;
}

ComPath solve_com_path(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                       const Vec3& goal) {
  const std::size_t n = knots.size();
  if (n < 2) throw std::invalid_argument("solve_com_path: at least two VRP knots are needed");
  // Rows of A: divergent (0) and convergent (1) component, scaled so that neither overflows.
  const double T = knots[n - 1].t;
  Eigen::Matrix<double, 2, Eigen::Dynamic> A =
      Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, static_cast<Eigen::Index>(n));
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const double a = omega * (knots[k + 1].t - knots[k].t);
    if (!(a > 0.0)) throw std::invalid_argument("solve_com_path: knot times must increase");
    const double E = std::exp(-a);
    const double F = (1.0 - E) / a;
    const auto i = static_cast<Eigen::Index>(k);
    // Divergent: c_k gets e^{-ωt_k}(1−F), c_{k+1} gets e^{-ωt_k}(F−E).
    const double forward = std::exp(-omega * knots[k].t);
    A(0, i) += forward * (1.0 - F);
    A(0, i + 1) += forward * (F - E);
    // Convergent, times e^{-ωT}: written with e^{-a} so that it stays well conditioned,
    // e^{ωt_k}(G−1) = e^{ωt_{k+1}}(F − E) and e^{ωt_k}(e^a−G) = e^{ωt_{k+1}}(1 − F).
    const double backward = std::exp(-omega * (T - knots[k + 1].t));
    A(1, i) += backward * (F - E);
    A(1, i + 1) += backward * (1.0 - F);
  }
  const double decay = std::exp(-omega * T);
  Eigen::Matrix<double, 2, 3> b;
  b.row(0) = (p0 + dp0 / omega) - decay * goal;
  b.row(1) = goal - decay * (p0 - dp0 / omega);

  Eigen::Matrix<double, 2, 2> gram = Eigen::Matrix<double, 2, 2>::Zero();
  Eigen::Matrix<double, 2, 3> residual = b;
  for (std::size_t k = 0; k < n; ++k) {
    if (!(knots[k].weight > 0.0)) throw std::invalid_argument("solve_com_path: knot weights must be positive");
    const Eigen::Vector2d column = A.col(static_cast<Eigen::Index>(k));
    gram += column * column.transpose() / knots[k].weight;
    residual -= column * knots[k].wish.transpose();
  }
  const Eigen::Matrix<double, 2, 3> multiplier = gram.inverse() * residual;
  std::vector<double> times(n);
  std::vector<Vec3> values(n);
  for (std::size_t k = 0; k < n; ++k) {
    times[k] = knots[k].t;
    values[k] = knots[k].wish + multiplier.transpose() * A.col(static_cast<Eigen::Index>(k)) / knots[k].weight;
  }
  return {omega, std::move(times), std::move(values), p0, dp0};
}

Vec2 zmp_of_vrp(const Vec3& com, const Vec3& v, double z_ground, double omega) {
  const double lever = com.z() - v.z() + kGravity / (omega * omega);
  if (!(lever > 0.0)) return Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
  return com.head<2>() - (com - v).head<2>() * ((com.z() - z_ground) / lever);
}

}  // namespace baton
