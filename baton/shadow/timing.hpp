/// How measurements came.
#pragma once

#include "baton/link/message.hpp"
#include "baton/shadow/statistic.hpp"

namespace baton::shadow {

class Timing {
 public:
  /// @param period of a tick [s]
  explicit Timing(double period) : period_(period) {}

  enum class Kind {
    next,          ///< one tick later, or some
    repeated,      ///< nothing was measured since the last one
    out_of_order,  ///< older than one that has come before: not to be used
    anew,          ///< the robot has begun anew: its clock was set back, or stood still for long
  };
  /// Takes a measurement.
  Kind take(const link::Reading& reading);

  /// Time that was seen, without what lies between two beginnings [s].
  [[nodiscard]] double seconds() const { return seconds_; }

  long measurements = 0;
  long lost = 0;  ///< by their numbers
  long repeated = 0;
  long out_of_order = 0;
  long late = 0;       ///< that were older than `kOld` ticks when they were sent
  long begun = 0;      ///< how often the robot began, the first time included
  Statistic interval;  ///< from one measurement to the next, by the robot's clock [s]
  Statistic age;       ///< when they were sent [s]

  static constexpr double kOld = 4.0;   ///< age of a measurement that is late [period]
  static constexpr double kAnew = 0.5;  ///< pause after which nothing is known of the robot any more [s]

 private:
  double period_;
  std::uint64_t expected_ = 0;  ///< number of the next measurement
  double t_ = 0.0;              ///< of the last one [s]
  double seconds_ = 0.0;
};

}  // namespace baton::shadow
