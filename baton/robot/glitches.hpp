/// Faults of sensors: readings that are not numbers, jump, stick, are exchanged, or come late.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

#include "baton/balance/measurement.hpp"

namespace baton {

/// What happens to a reading.
enum class Fault {
  nan,        ///< one or all of its numbers are NaN
  infinite,   ///< one or all of them are infinite
  spike,      ///< one is off by a constant; an attitude is turned
  stuck,      ///< it stays as it was
  exchanged,  ///< two of its numbers are exchanged; of the forces, left and right
  held,       ///< the whole measurement stays as it was
};
inline constexpr std::size_t kFaults = static_cast<std::size_t>(Fault::held) + 1;

[[nodiscard]] constexpr std::string_view to_string(Fault fault) {
  constexpr std::array<std::string_view, kFaults> names{"nan", "infinite", "spike", "stuck", "exchanged", "held"};
  return names[static_cast<std::size_t>(fault)];
}

/// A field of a measurement.
enum class Reading { angles, speeds, torques, attitude, gyro, accelerometer, forces };
inline constexpr std::size_t kReadings = static_cast<std::size_t>(Reading::forces) + 1;

[[nodiscard]] constexpr std::string_view to_string(Reading reading) {
  constexpr std::array<std::string_view, kReadings> names{"angles", "speeds",        "torques", "attitude",
                                                          "gyro",   "accelerometer", "forces"};
  return names[static_cast<std::size_t>(reading)];
}

/// One fault after another, of random kind and in a random reading.
class Glitches {
 public:
  /// @param interval longest time from one fault to the next; the shortest is a fifth of it [s]
  /// @param period of the measurements [s]
  Glitches(double interval, double period, std::uint64_t seed);

  /// Applies the fault that is due, if any. Call it once for each measurement.
  void spoil(Measurement& measurement);

  /// Whether the latest measurement was spoiled; if so, how.
  [[nodiscard]] bool active() const { return left_ > 0; }
  [[nodiscard]] Fault fault() const { return fault_; }
  [[nodiscard]] Reading reading() const { return reading_; }

 private:
  void begin(Measurement& measurement);
  [[nodiscard]] double uniform(double from, double to);
  [[nodiscard]] std::size_t index(std::size_t size);

  double interval_;
  double period_;
  std::mt19937_64 random_;
  long wait_;      ///< ticks until the next fault
  long left_ = 0;  ///< ticks that the present one lasts
  Fault fault_ = Fault::nan;
  Reading reading_ = Reading::angles;
  bool all_ = false;              ///< whether it is in all numbers of the reading
  std::size_t one_ = 0;           ///< index of the number that it is in
  std::size_t other_ = 0;         ///< index of the number exchanged with it
  double size_ = 0.0;             ///< of a spike
  Mat3 turn_ = Mat3::Identity();  ///< of the attitude
  Measurement before_;            ///< at the begin
};

}  // namespace baton
