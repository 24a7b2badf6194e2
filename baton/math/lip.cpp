#include "baton/math/lip.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace baton {

namespace {

/// Coefficients of an interval of length h, with a = ωh: E = e^{−a}, F = (1 − E)/a.
struct Decay {
  explicit Decay(double a) : E(std::exp(-a)), F(a > 1e-9 ? (1.0 - E) / a : 1.0 - 0.5 * a) {}
  double E, F;
};

}  // namespace

Vec3 VrpOffset::at(double t) const {
  if (times.empty()) return Vec3::Zero();
  const auto next = std::upper_bound(times.begin(), times.end(), t);
  if (next == times.begin()) return values.front();
  if (next == times.end()) return values.back();
  const auto k = static_cast<std::size_t>(next - times.begin());
  const double s = (t - times[k - 1]) / (times[k] - times[k - 1]);
  return values[k - 1] + s * (values[k] - values[k - 1]);
}

ComPath::ComPath(double omega, std::vector<double> times, std::vector<Vec3> knots, const Vec3& p0, const Vec3& dp0,
                 const VrpOffset& offset)
    : omega_(omega), times_(std::move(times)), knots_(std::move(knots)) {
  constexpr double kSame = 1e-9;  // [s]
  std::size_t next = 0;           // index into the offset's nodes
  for (std::size_t k = 0; k < times_.size(); ++k) {
    for (; next < offset.times.size() && offset.times[next] < times_[k] - kSame; ++next) {
      const double t = offset.times[next];
      if (k == 0 || t < times_[k - 1] + kSame) continue;
      const double s = (t - times_[k - 1]) / (times_[k] - times_[k - 1]);
      const Vec3 v = knots_[k - 1] + s * (knots_[k] - knots_[k - 1]);
      nodes_.push_back({t, v, v - offset.values[next]});
    }
    nodes_.push_back({times_[k], knots_[k], knots_[k] - offset.at(times_[k])});
  }
  nodes_.front().p = p0;
  nodes_.front().dp = dp0;
  for (std::size_t k = 1; k < nodes_.size(); ++k) {
    const ComState end = between(nodes_[k - 1], nodes_[k], nodes_[k].t);
    nodes_[k].p = end.p;
    nodes_[k].dp = end.dp;
  }
}

ComState ComPath::between(const Node& a, const Node& b, double t) const {
  const double h = b.t - a.t;
  const double tau = t - a.t;
  const Vec3 rate = (b.drive - a.drive) / h;
  const double c = std::cosh(omega_ * tau);
  const double s = std::sinh(omega_ * tau);
  const Vec3 drive = a.drive + rate * tau;
  const Vec3 x = a.p - a.drive;
  const Vec3 y = (a.dp - rate) / omega_;
  ComState state;
  state.p = drive + x * c + y * s;
  state.dp = rate + omega_ * (x * s + y * c);
  state.ddp = omega_ * omega_ * (state.p - drive);
  state.v = a.v + (b.v - a.v) * (tau / h);
  return state;
}

ComState ComPath::at(double t) const {
  const double clamped = std::clamp(t, 0.0, times_.back());
  const auto next = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, clamped,
                                     [](double value, const Node& node) { return value < node.t; });
  return between(*(next - 1), *next, clamped);
}

KnotResponse knot_response(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                           const Vec3& goal, const VrpOffset& offset) {
  const std::size_t count = knots.size();
  const auto n = static_cast<Eigen::Index>(count);
  if (count < 2) throw std::invalid_argument("knot_response: at least two VRP knots are needed");
  std::vector<Decay> decay;
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const double h = knots[k + 1].t - knots[k].t;
    if (!(h > 0.0)) throw std::invalid_argument("knot_response: knot times must increase");
    decay.emplace_back(omega * h);
  }
  KnotResponse r;
  r.xi.setZero(n, n);
  r.eta.setZero(n, n);
  r.xi0.setZero(n, 3);
  r.eta0.setZero(n, 3);
  r.xi0.row(n - 1) = goal;
  for (Eigen::Index k = n - 2; k >= 0; --k) {
    const auto [E, F] = decay[static_cast<std::size_t>(k)];
    r.xi.row(k) = E * r.xi.row(k + 1);
    r.xi(k, k) += 1.0 - F;
    r.xi(k, k + 1) += F - E;
    r.xi0.row(k) = E * r.xi0.row(k + 1);
  }
  r.eta0.row(0) = p0 - dp0 / omega;
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    const auto [E, F] = decay[static_cast<std::size_t>(k)];
    r.eta.row(k + 1) = E * r.eta.row(k);
    r.eta(k + 1, k) += F - E;
    r.eta(k + 1, k + 1) += 1.0 - F;
    r.eta0.row(k + 1) = E * r.eta0.row(k);
  }
  if (!offset.times.empty()) {
    // The contribution of the offset: the same recursions, from one of its nodes to the next.
    const std::size_t last = offset.times.size() - 1;
    std::vector<Vec3> forward(last + 1, Vec3::Zero()), backward(last + 1, Vec3::Zero());
    for (std::size_t k = 0; k < last; ++k) {
      const Decay d(omega * (offset.times[k + 1] - offset.times[k]));
      forward[k + 1] = d.E * forward[k] + (d.F - d.E) * offset.values[k] + (1.0 - d.F) * offset.values[k + 1];
    }
    for (std::size_t k = last; k > 0; --k) {
      const Decay d(omega * (offset.times[k] - offset.times[k - 1]));
      backward[k - 1] = d.E * backward[k] + (1.0 - d.F) * offset.values[k - 1] + (d.F - d.E) * offset.values[k];
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      const double t = knots[static_cast<std::size_t>(k)].t;
      const auto next = std::upper_bound(offset.times.begin() + 1, offset.times.end() - 1, t) - offset.times.begin();
      const auto i = static_cast<std::size_t>(next) - 1;
      const Vec3 here = offset.at(t);
      const Decay before(omega * std::max(0.0, t - offset.times[i]));
      const Decay after(omega * std::max(0.0, offset.times[i + 1] - t));
      const Vec3 eta = before.E * forward[i] + (before.F - before.E) * offset.values[i] + (1.0 - before.F) * here;
      const Vec3 xi = after.E * backward[i + 1] + (1.0 - after.F) * here + (after.F - after.E) * offset.values[i + 1];
      r.eta0.row(k) -= eta;
      r.xi0.row(k) -= xi;
    }
  }
  r.A.resize(2, n);
  r.A.row(0) = r.xi.row(0);
  r.A.row(1) = r.eta.row(n - 1);
  r.b.row(0) = (p0 + dp0 / omega).transpose() - r.xi0.row(0);
  r.b.row(1) = goal.transpose() - r.eta0.row(n - 1);
  return r;
}

std::vector<Vec3> nearest_knots(std::span<const VrpKnot> knots, const KnotResponse& response) {
  Eigen::Matrix<double, 2, 2> gram = Eigen::Matrix<double, 2, 2>::Zero();
  Eigen::Matrix<double, 2, 3> residual = response.b;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (!(knots[k].weight > 0.0)) throw std::invalid_argument("nearest_knots: knot weights must be positive");
    const Eigen::Vector2d column = response.A.col(static_cast<Eigen::Index>(k));
    gram += column * column.transpose() / knots[k].weight;
    residual -= column * knots[k].wish.transpose();
  }
  const Eigen::Matrix<double, 2, 3> multiplier = gram.inverse() * residual;
  std::vector<Vec3> values;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const Eigen::Vector2d column = response.A.col(static_cast<Eigen::Index>(k));
    values.emplace_back(knots[k].wish + multiplier.transpose() * column / knots[k].weight);
  }
  return values;
}

ComPath solve_com_path(double omega, std::span<const VrpKnot> knots, const Vec3& p0, const Vec3& dp0,
                       const Vec3& goal) {
  const KnotResponse response = knot_response(omega, knots, p0, dp0, goal, {});
  std::vector<double> times;
  for (const VrpKnot& knot : knots)
    times.push_back(knot.t);
  return {omega, std::move(times), nearest_knots(knots, response), p0, dp0};
}

Vec2 zmp_of_vrp(const Vec3& com, const Vec3& v, double z_ground, double omega) {
  const double lever = com.z() - v.z() + kGravity / (omega * omega);
  if (!(lever > 0.0)) return Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
  return com.head<2>() - (com - v).head<2>() * ((com.z() - z_ground) / lever);
}

}  // namespace baton
