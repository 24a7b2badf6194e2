/// What happens to a robot that is navigated, as it happens.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <variant>

#include "baton/navigate/watch.hpp"

namespace baton {

/// A motion was committed: `Navigator::motion()`.
struct Committed {
  long segment = 0;  ///< its number, from 0
};
/// The motion under way is over: the robot rests, or has fallen. One that is replaced on its way does not end.
struct Ended {};
/// A command was refused: `Navigator::refusal()`.
struct Refused {
  bool again = false;  ///< a refusal stood already
};
/// The arms cannot follow what drives them, or only in part: `Navigator::arms_refusal()`.
struct ArmsRefused {};
/// An answer was not there at the take-over.
struct AnswerLate {};
/// Soles slid too far from where they were planned for the way back to be kept.
struct Slipped {
  double distance = 0.0;  ///< [m]
};
/// The DCM left the tube around the planned one, or came back.
struct DisturbedChanged {
  bool disturbed = false;
};
struct GuardChanged {
  Guard from = Guard::armed;
  Guard to = Guard::armed;
};

/// A sensor's readings are rejected, or believed again.
struct SensorChanged {
  Sensor sensor = Sensor::encoders;
  Health health = Health::good;
};

/// A motor got so hot that nothing new is begun, or all have cooled down: `Navigator::thermometer()`.
struct HeatChanged {
  bool hot = false;
};

using Event = std::variant<Committed, Ended, Refused, AnswerLate, Slipped, DisturbedChanged, GuardChanged,
                           SensorChanged, HeatChanged, ArmsRefused>;

/// The event of a kind; null if there is none among these.
template <typename Kind>
[[nodiscard]] const Kind* find_event(std::span<const Event> events) {
  for (const Event& event : events) {
    if (const auto* found = std::get_if<Kind>(&event)) return found;
  }
  return nullptr;
}

/// The events of one tick.
class Events {
 public:
  void add(const Event& event) {
    if (count_ < events_.size()) events_[count_++] = event;
  }
  void clear() { count_ = 0; }
  [[nodiscard]] std::span<const Event> list() const { return {events_.data(), count_}; }

 private:
  std::array<Event, 24> events_;  ///< more than a tick can have: each kind happens twice, or once for each sensor
  std::size_t count_ = 0;
};

}  // namespace baton
