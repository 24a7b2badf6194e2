/// Events as Python sees them: those of a tick, with its time and what they are about.
#pragma once

#include "baton/navigate/navigator.hpp"
#include "module.hpp"

namespace baton::python {

struct CommittedEvent {
  double t = 0.0;
  long segment = 0;
  Purpose purpose = Purpose::none;
  SegmentKind kind = SegmentKind::shift;
  Part guided = Part::trunk;
  double duration = 0.0;
  std::optional<Refusal> limit;
};
struct EndedEvent {
  double t = 0.0;
};
struct RefusedEvent {
  double t = 0.0;
  Refusal refusal;
  bool again = false;
};
struct AnswerLateEvent {
  double t = 0.0;
};
struct SlippedEvent {
  double t = 0.0;
  double distance = 0.0;
};
struct DisturbedChangedEvent {
  double t = 0.0;
  bool disturbed = false;
};
struct GuardChangedEvent {
  double t = 0.0;
  Guard before = Guard::armed;
  Guard now = Guard::armed;
};
struct SensorChangedEvent {
  double t = 0.0;
  Sensor sensor = Sensor::encoders;
  Health health = Health::good;
};
struct HeatChangedEvent {
  double t = 0.0;
  bool hot = false;
};

struct ArmsRefusedEvent {
  double t = 0.0;
  Refusal refusal;
};

using PythonEvent =
    std::variant<CommittedEvent, EndedEvent, RefusedEvent, AnswerLateEvent, SlippedEvent, DisturbedChangedEvent,
                 GuardChangedEvent, SensorChangedEvent, HeatChangedEvent, ArmsRefusedEvent>;

/// @param navigator just after the tick of the event
[[nodiscard]] PythonEvent event_of(const Event& event, double t, const Navigator& navigator);

}  // namespace baton::python
