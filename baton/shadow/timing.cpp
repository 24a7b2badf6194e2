#include "baton/shadow/timing.hpp"

namespace baton::shadow {

Timing::Kind Timing::take(const link::Reading& reading) {
  const double t = reading.measurement.t;
  const double passed = t - t_;
  ++measurements;
  age.add(reading.measurement.age, seconds_);
  if (reading.measurement.age > kOld * period_) ++late;
  if (measurements > 1 && reading.sequence < expected_) {
    ++out_of_order;
    return Kind::out_of_order;
  }
  if (measurements > 1) lost += static_cast<long>(reading.sequence - expected_);
  expected_ = reading.sequence + 1;
  if (!std::isfinite(t) || (begun > 0 && passed == 0.0)) {
    ++repeated;
    return Kind::repeated;
  }
  if (begun > 0 && passed > 0.0 && passed <= kAnew) {
    interval.add(passed, seconds_);
    seconds_ += passed;
    t_ = t;
    return Kind::next;
  }
  ++begun;
  t_ = t;
  return Kind::anew;
}

}  // namespace baton::shadow
