#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "baton/balance/measurement.hpp"
#include "baton/robot/robot.hpp"
#include "module.hpp"

namespace baton::python {
namespace {

using Pair = std::pair<double, double>;

Recall recall_named(const std::string& name) {
  const auto* const found = std::ranges::find(kRecalls, name);
  if (found == kRecalls.end())
    throw InputError(fmt::format("recall {:?}: must be one of {}", name, fmt::join(kRecalls, ", ")));
  return static_cast<Recall>(found - kRecalls.begin());
}

Command command(const std::string& guide, const nb::object& axes, Pair lift, const std::string& recall) {
  Command command{part_named(guide), Vec6::Zero(), {lift.first, lift.second}, recall_named(recall)};
  if (!axes.is_none()) command.axes = numbers<Vec6>("axes", axes);
  return command;
}

Wrench wrench(const char* name, const nb::object& given) {
  if (given.is_none()) return {};
  const auto six = numbers<Vec6>(name, given);
  return {six.head<3>(), six.tail<3>()};
}

Measurement measurement(double t, const nb::object& q, const nb::object& dq, const nb::object& attitude,
                        const nb::object& rate, const nb::object& acceleration, const nb::object& left_sole,
                        const nb::object& right_sole, const nb::object& torque, double age) {
  if (!(age >= 0.0 && age < 1e6)) throw InputError(fmt::format("age {}: must be 0 or more, and finite", age));
  Measurement m;
  m.t = t;
  m.age = age;
  m.q = numbers<VecX>("q", q);
  m.dq = numbers<VecX>("dq", dq);
  if (!torque.is_none()) m.torque = numbers<VecX>("torque", torque);
  m.imu = {numbers<Mat3>("attitude", attitude), numbers<Vec3>("rate", rate),
           numbers<Vec3>("acceleration", acceleration)};
  m.sole = {wrench("left_sole", left_sole), wrench("right_sole", right_sole)};
  return m;
}

}  // namespace

Part part_named(const std::string& name) {
  for (const Part part : kParts) {
    if (name == to_string(part)) return part;
  }
  std::vector<std::string_view> names;
  for (const Part part : kParts)
    names.push_back(to_string(part));
  throw InputError(fmt::format("part {:?}: must be one of {}", name, fmt::join(names, ", ")));
}

void bind_signals(nb::module_& m) {
  nb::class_<Command> command_class(m, "Command", "A position of the stick, which holds until the next.");
  command_class.attr("__hash__") = nb::none();  // it compares by value
  command_class
      .def(
          "__init__",
          [](Command* self, const std::string& guide, const nb::object& axes, Pair lift, const std::string& recall) {
            new (self) Command(command(guide, axes, lift, recall));
          },
          nb::arg("guide") = "trunk", nb::arg("axes") = nb::none(), nb::kw_only(), nb::arg("lift") = Pair(0.0, 0.0),
          nb::arg("recall") = "none",
          nb::sig("def __init__(self, guide: str = 'trunk', axes: numpy.typing.ArrayLike | None = None, *, lift: "
                  "tuple[float, float] = (0.0, 0.0), recall: str = 'none') -> None"),
          "guide: the guided part: 'left_foot', 'right_foot', 'left_hand', 'right_hand' or 'trunk'.\n"
          "axes: (6), −1…1: forward, left, up, roll, pitch, yaw, as the robot is heading; None: centred.\n"
          "lift: levers of left and right foot, 0…1.\n"
          "recall: 'none', 'retrace', 'home' or 'stop'; takes precedence over the axes.")
      .def_prop_ro("guide", [](const Command& c) { return std::string(to_string(c.guide)); })
      .def_ro("axes", &Command::axes, nb::rv_policy::copy)
      .def_prop_ro("lift", [](const Command& c) { return Pair(c.lift.left, c.lift.right); })
      .def_prop_ro("recall", [](const Command& c) { return std::string(kRecalls[static_cast<std::size_t>(c.recall)]); })
      .def(
          "__eq__", [](const Command& a, const Command& b) { return a == b; }, nb::is_operator())
      .def("__repr__", [](const Command& c) {
        return fmt::format("Command({:?}, [{:.3g}], lift=({:.3g}, {:.3g}), recall={:?})", to_string(c.guide),
                           fmt::join(c.axes, ", "), c.lift.left, c.lift.right,
                           kRecalls[static_cast<std::size_t>(c.recall)]);
      });

  nb::class_<Measurement>(m, "Measurement", "What a robot's sensors say.")
      .def(
          "__init__",
          [](Measurement* self, double t, const nb::object& q, const nb::object& dq, const nb::object& attitude,
             const nb::object& rate, const nb::object& acceleration, const nb::object& left_sole,
             const nb::object& right_sole, const nb::object& torque, double age) {
            new (self)
                Measurement(measurement(t, q, dq, attitude, rate, acceleration, left_sole, right_sole, torque, age));
          },
          nb::kw_only(), nb::arg("t"), nb::arg("q"), nb::arg("dq"), nb::arg("attitude"), nb::arg("rate"),
          nb::arg("acceleration"), nb::arg("left_sole") = nb::none(), nb::arg("right_sole") = nb::none(),
          nb::arg("torque") = nb::none(), nb::arg("age") = 0.0,
          nb::sig("def __init__(self, *, t: float, q: numpy.typing.ArrayLike, dq: numpy.typing.ArrayLike, attitude: "
                  "numpy.typing.ArrayLike, rate: numpy.typing.ArrayLike, acceleration: numpy.typing.ArrayLike, "
                  "left_sole: numpy.typing.ArrayLike | None = None, right_sole: numpy.typing.ArrayLike | None = None, "
                  "torque: numpy.typing.ArrayLike | None = None, age: float = 0.0) -> None"),
          "Each value as the attribute of its name; soles None: no force.")
      .def_ro("t", &Measurement::t, "When the sensors were read [s]; only recorded, `age` counts.")
      .def_ro("age", &Measurement::age, "Time from then until now, by the robot's clock [s].")
      .def_ro("q", &Measurement::q, nb::rv_policy::copy, "Joint angles (n) [rad].")
      .def_ro("dq", &Measurement::dq, nb::rv_policy::copy, "Joint speeds (n) [rad/s].")
      .def_prop_ro(
          "torque", [](const Measurement& r) { return r.torque.size() > 0 ? std::optional(r.torque) : std::nullopt; },
          "Motor torques (n) [N·m]; None: not measured.")
      .def_prop_ro(
          "attitude", [](const Measurement& r) { return r.imu.attitude; },
          "Rotation matrix (3, 3) of the IMU in its world frame, whose yaw is arbitrary.")
      .def_prop_ro(
          "rate", [](const Measurement& r) { return r.imu.rate; }, "Angular velocity in the IMU's frame (3) [rad/s].")
      .def_prop_ro(
          "acceleration", [](const Measurement& r) { return r.imu.acceleration; },
          "Specific force in the IMU's frame (3) [m/s²]: (0, 0, 9.81) when it lies still.")
      .def_prop_ro(
          "left_sole", [](const Measurement& r) { return vector_of(r.sole.left); },
          "Force [N] and moment [N·m] of the ground on the sole, in its frame, about its centre (6).")
      .def_prop_ro("right_sole", [](const Measurement& r) { return vector_of(r.sole.right); })
      .def("__repr__", [](const Measurement& r) { return fmt::format("Measurement(t={:.3f})", r.t); });

  nb::class_<JointTarget>(m, "JointTarget", "What the joints are told for the end of a tick, (n) each.")
      .def_ro("q", &JointTarget::q, nb::rv_policy::copy, "Planned angles [rad].")
      .def_ro("dq", &JointTarget::dq, nb::rv_policy::copy, "Planned speeds [rad/s].")
      .def_ro("ddq", &JointTarget::ddq, nb::rv_policy::copy, "Planned accelerations [rad/s²].")
      .def_ro("tau", &JointTarget::tau, nb::rv_policy::copy, "Feed-forward torques, corrections included [N·m].")
      .def_prop_ro(
          "q_correction",
          [](const JointTarget& t) {
            return t.q_correction.size() > 0 ? t.q_correction : VecX::Zero(t.q.size()).eval();
          },
          "What balance adds to the angles [rad].")
      .def_prop_ro(
          "contact", [](const JointTarget& t) { return std::pair(t.contact.left, t.contact.right); },
          "Whether the left and the right sole are to stand.");

  nb::class_<Truth>(m, "Truth", "The simulated robot as it is, for graders and pictures; nothing steers by it.")
      .def_ro("t", &Truth::t, "[s]")
      .def_ro("q", &Truth::q, nb::rv_policy::copy, "Configuration (nq), as in Robot.")
      .def_ro("dq", &Truth::dq, nb::rv_policy::copy,
              "Velocity (6 + n): first body linear in the world, angular in its frame, then joint speeds [m/s, rad/s].")
      .def_prop_ro(
          "left_sole", [](const Truth& t) { return vector_of(t.sole.left); },
          "Force [N] and moment [N·m] of the ground on the sole in world axes, about the origin of the world (6).")
      .def_prop_ro("right_sole", [](const Truth& t) { return vector_of(t.sole.right); })
      .def_ro("fallen", &Truth::fallen)
      .def_ro("fall", &Truth::fall, "What the fall was, or empty.");
}

}  // namespace baton::python
