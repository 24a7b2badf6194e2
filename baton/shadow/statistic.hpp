/// How a quantity behaved.
#pragma once

#include <cmath>

namespace baton::shadow {

struct Statistic {
  long n = 0;
  double sum = 0.0;
  double squares = 0.0;
  double worst = 0.0;  ///< the value farthest from zero
  double when = 0.0;   ///< that was [s]

  void add(double value, double t) {
    if (!std::isfinite(value)) return;
    ++n;
    sum += value;
    squares += value * value;
    if (std::abs(value) <= std::abs(worst)) return;
    worst = value;
    when = t;
  }
  [[nodiscard]] double mean() const { return n > 0 ? sum / static_cast<double>(n) : 0.0; }
  [[nodiscard]] double rms() const { return n > 0 ? std::sqrt(squares / static_cast<double>(n)) : 0.0; }
};

}  // namespace baton::shadow
