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
/// The motion under way has ended: the robot rests.
struct Rested {};
/// A command was refused: `Navigator::refusal()`.
struct Refused {};
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

using Event = std::variant<Committed, Rested, Refused, AnswerLate, Slipped, DisturbedChanged, GuardChanged>;

/// The events of one tick.
class Events {
 public:
  void add(const Event& event) {
    if (count_ < events_.size()) events_[count_++] = event;
  }
  void clear() { count_ = 0; }
  [[nodiscard]] std::span<const Event> list() const { return {events_.data(), count_}; }

 private:
  std::array<Event, 16> events_;  ///< more than a tick and its poll can have: each kind happens twice at most
  std::size_t count_ = 0;
};

}  // namespace baton
