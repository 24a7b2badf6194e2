/// Seeded random numbers, vectors and poses.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "baton/math/pose.hpp"

namespace baton::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double operator()(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine_); }
  std::size_t below(std::size_t n) { return engine_() % n; }
  int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine_); }
  bool coin() { return below(2) == 0; }
  /// Of any size from tiny to absurd.
  double wild() { return (coin() ? 1.0 : -1.0) * std::pow(10.0, (*this)(-6.0, 12.0)); }

  /// Each coordinate at most `size`.
  Vec3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
  VecX vector(Eigen::Index n, double size) {
    return VecX::NullaryExpr(n, [&](Eigen::Index) { return (*this)(-size, size); });
  }
  Vec3 wild_vector() { return {wild(), wild(), wild()}; }
  /// Horizontal, each coordinate at most `size`.
  Vec3 horizontal(double size) { return {(*this)(-size, size), (*this)(-size, size), 0.0}; }
  /// Horizontal, of length 1.
  Vec3 direction() { return rotation_z((*this)(-M_PI, M_PI)).col(0); }

  Pose pose() { return {vector(2.0), rotation_exp(vector(2.0))}; }
  /// A place, a height and a yaw.
  Pose upright() { return {vector(2.0), rotation_z((*this)(-M_PI, M_PI))}; }
  /// The same at height 0.
  Pose on_the_floor() { return {horizontal(2.0), rotation_z((*this)(-M_PI, M_PI))}; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace baton::test
