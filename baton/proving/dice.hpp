/// Random numbers that are identical on every platform.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace baton {

/// Seed of one of many random streams, mixed so that neighbouring seeds are uncorrelated.
[[nodiscard]] std::uint64_t mixed_seed(std::uint64_t seed, std::uint64_t stream);

/// Random integers, and values derived from them by exact arithmetic.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  /// 0 … n − 1.
  [[nodiscard]] int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  /// lo … hi.
  [[nodiscard]] int between(int lo, int hi) { return lo + below(hi - lo + 1); }
  [[nodiscard]] bool percent(int chance) { return below(100) < chance; }
  [[nodiscard]] double sign() { return percent(50) ? 1.0 : -1.0; }
  /// In [0, 1), a multiple of 2⁻⁵³.
  [[nodiscard]] double share() { return std::ldexp(static_cast<double>(engine_() >> 11), -53); }
  /// In [−1, 1], a multiple of 1/1024.
  [[nodiscard]] double axis() { return (below(2049) - 1024) / 1024.0; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace baton
