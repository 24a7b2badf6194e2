/// Random numbers that are identical on every platform.
#pragma once

#include <cstdint>
#include <random>

#include "baton/model/profile.hpp"

namespace baton::bench {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double real(double lo, double hi) { return lo + (hi - lo) * 0x1p-53 * static_cast<double>(engine_() >> 11); }
  double real(const Range& range) { return real(range.lo, range.hi); }
  int below(int n) { return static_cast<int>(real(0.0, n)); }
  bool chance(double share) { return real(0.0, 1.0) < share; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace baton::bench
