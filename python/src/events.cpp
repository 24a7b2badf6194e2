#include "events.hpp"

#include <fmt/format.h>

namespace baton::python {
namespace {

/// A getter of an enumerator's name.
template <typename Object, typename Value>
auto name_of(Value Object::*field) {
  return [field](const Object& object) { return std::string(to_string(object.*field)); };
}

struct Convert {
  double t;
  const Navigator& navigator;

  PythonEvent operator()(const Committed& e) const {
    const Goal& goal = navigator.motion()->goal;
    return CommittedEvent{t,
                          e.segment,
                          navigator.purpose(),
                          goal.kind,
                          goal.guided,
                          navigator.motion()->duration(),
                          navigator.planned()->limit};
  }
  PythonEvent operator()(const Ended&) const { return EndedEvent{t}; }
  PythonEvent operator()(const Refused& e) const { return RefusedEvent{t, *navigator.refusal(), e.again}; }
  PythonEvent operator()(const AnswerLate&) const { return AnswerLateEvent{t}; }
  PythonEvent operator()(const Slipped& e) const { return SlippedEvent{t, e.distance}; }
  PythonEvent operator()(const DisturbedChanged& e) const { return DisturbedChangedEvent{t, e.disturbed}; }
  PythonEvent operator()(const GuardChanged& e) const { return GuardChangedEvent{t, e.from, e.to}; }
  PythonEvent operator()(const SensorChanged& e) const { return SensorChangedEvent{t, e.sensor, e.health}; }
  PythonEvent operator()(const ArmsRefused&) const { return ArmsRefusedEvent{t, *navigator.arms_refusal()}; }
  PythonEvent operator()(const HeatChanged& e) const { return HeatChangedEvent{t, e.hot}; }
};

constexpr std::string_view symbol(Unit unit) {
  switch (unit) {
    case Unit::length:
      return " m";
    case Unit::angle:
      return " rad";
    case Unit::speed:
      return " rad/s";
    case Unit::acceleration:
      return " rad/s²";
    default:
      return "";
  }
}

std::string text_of(const Refusal& refusal) {
  std::string text = fmt::format("{}: {}", to_string(refusal.part), info(refusal.reason).text);
  if (refusal.cause) text += fmt::format(": {}", info(*refusal.cause).text);
  if (!refusal.where.empty()) text += fmt::format(" ({})", refusal.where);
  const ReasonInfo& numbers = info(refusal.cause.value_or(refusal.reason));
  if (numbers.unit != Unit::none) {
    const std::string_view unit = symbol(numbers.unit);
    text += fmt::format(": {:.4g}{}, limit {:.4g}{}", refusal.value, unit, refusal.limit, unit);
  }
  return text;
}

template <typename E>
nb::class_<E> bind(nb::module_& m, const char* name, const char* doc) {
  return nb::class_<E>(m, name, doc).def_ro("t", &E::t, "When it happened, from the start of the run [s].");
}

}  // namespace

PythonEvent event_of(const Event& event, double t, const Navigator& navigator) {
  return std::visit(Convert{t, navigator}, event);
}

void bind_events(nb::module_& m) {
  nb::class_<Refusal>(m, "Refusal", "Why a command has no verified motion, or only one that does a part of it.")
      .def_prop_ro("reason", name_of(&Refusal::reason), "One of the reasons in docs/refusals.md.")
      .def_prop_ro("part", name_of(&Refusal::part))
      .def_ro("value", &Refusal::value, "What violates the limit.")
      .def_ro("limit", &Refusal::limit)
      .def_ro("where", &Refusal::where, "Joint, pair of links or place; may be empty.")
      .def_prop_ro(
          "cause",
          [](const Refusal& r) { return r.cause ? std::optional(std::string(to_string(*r.cause))) : std::nullopt; },
          "The reason behind it, whose part, value and limit these are then.")
      .def_prop_ro(
          "unit", [](const Refusal& r) { return std::string(to_string(info(r.cause.value_or(r.reason)).unit)); },
          "Of value and limit: 'length' [m], 'angle' [rad], 'speed' [rad/s], 'acceleration' [rad/s²], "
          "'share', 'number', 'none'.")
      .def("__str__", &text_of)
      .def("__repr__", [](const Refusal& r) { return fmt::format("Refusal({})", text_of(r)); });

  bind<CommittedEvent>(m, "Committed", "A verified motion begins.")
      .def_ro("segment", &CommittedEvent::segment, "Its number, from 0.")
      .def_prop_ro("purpose", name_of(&CommittedEvent::purpose),
                   "'follow', 'retrace', 'home', 'stop', 'capture' or 'cool'.")
      .def_prop_ro("kind", name_of(&CommittedEvent::kind), "'shift', 'step', 'lift', 'air', 'lower' or 'reach'.")
      .def_prop_ro("guided", name_of(&CommittedEvent::guided))
      .def_ro("duration", &CommittedEvent::duration, "Until it rests, if nothing replaces it [s].")
      .def_ro("limit", &CommittedEvent::limit, "Why it does only a part of what was asked for; None: it does all.")
      .def("__repr__", [](const CommittedEvent& e) {
        return fmt::format("Committed(t={:.3f}, segment={}, {} {}, {:.3f} s)", e.t, e.segment, to_string(e.guided),
                           to_string(e.kind), e.duration);
      });
  bind<EndedEvent>(m, "Ended", "The motion is over: the robot rests, or has fallen.")
      .def("__repr__", [](const EndedEvent& e) { return fmt::format("Ended(t={:.3f})", e.t); });
  bind<RefusedEvent>(m, "Refused", "A command has no verified motion; the robot stays with what it does.")
      .def_ro("refusal", &RefusedEvent::refusal)
      .def_ro("again", &RefusedEvent::again, "Whether a refusal stood already.")
      .def("__repr__",
           [](const RefusedEvent& e) { return fmt::format("Refused(t={:.3f}, {})", e.t, text_of(e.refusal)); });
  bind<AnswerLateEvent>(m, "AnswerLate", "A plan was not there in time, and was dropped.")
      .def("__repr__", [](const AnswerLateEvent& e) { return fmt::format("AnswerLate(t={:.3f})", e.t); });
  bind<SlippedEvent>(m, "Slipped", "Soles slid: the way back is forgotten.")
      .def_ro("distance", &SlippedEvent::distance, "[m]")
      .def("__repr__",
           [](const SlippedEvent& e) { return fmt::format("Slipped(t={:.3f}, distance={:.4f})", e.t, e.distance); });
  bind<DisturbedChangedEvent>(m, "DisturbedChanged", "The robot is too far off its plan to begin a motion, or no more.")
      .def_ro("disturbed", &DisturbedChangedEvent::disturbed)
      .def("__repr__", [](const DisturbedChangedEvent& e) {
        return fmt::format("DisturbedChanged(t={:.3f}, disturbed={})", e.t, e.disturbed ? "True" : "False");
      });
  bind<GuardChangedEvent>(m, "GuardChanged", "Whether the robot may be moved: 'armed', 'lifted', 'fallen', 'stood_up'.")
      .def_prop_ro("before", name_of(&GuardChangedEvent::before))
      .def_prop_ro("now", name_of(&GuardChangedEvent::now))
      .def("__repr__", [](const GuardChangedEvent& e) {
        return fmt::format("GuardChanged(t={:.3f}, {} → {})", e.t, to_string(e.before), to_string(e.now));
      });
  bind<SensorChangedEvent>(m, "SensorChanged", "A sensor's readings are believed, or not.")
      .def_prop_ro("sensor", name_of(&SensorChangedEvent::sensor))
      .def_prop_ro("health", name_of(&SensorChangedEvent::health), "'good', 'bridged' or 'lost'.")
      .def("__repr__", [](const SensorChangedEvent& e) {
        return fmt::format("SensorChanged(t={:.3f}, {} {})", e.t, to_string(e.sensor), to_string(e.health));
      });
  bind<HeatChangedEvent>(m, "HeatChanged", "Motors are too hot to go on, or have cooled down.")
      .def_ro("hot", &HeatChangedEvent::hot)
      .def("__repr__", [](const HeatChangedEvent& e) {
        return fmt::format("HeatChanged(t={:.3f}, hot={})", e.t, e.hot ? "True" : "False");
      });
  bind<ArmsRefusedEvent>(m, "ArmsRefused", "The arms cannot follow what drives them, or only in part.")
      .def_ro("refusal", &ArmsRefusedEvent::refusal)
      .def("__repr__",
           [](const ArmsRefusedEvent& e) { return fmt::format("ArmsRefused(t={:.3f}, {})", e.t, text_of(e.refusal)); });
}

}  // namespace baton::python
