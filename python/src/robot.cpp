#include <fmt/format.h>

#include <cmath>

#include "baton/ik/stand.hpp"
#include "baton/model/world.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/robot/servo.hpp"
#include "module.hpp"

namespace baton::python {
namespace {

Robot load(const std::string& name_or_file, const std::optional<std::string>& drive) {
  const Away away;
  RobotModel model = RobotModel::load(name_or_file);
  if (drive) model = with_drive(model, drive_named(*drive, "drive"));
  return {std::make_shared<const RobotModel>(std::move(model))};
}

VecX gains(const Robot& robot, double Profile::Gains::*gain) {
  const std::vector<Joint>& joints = robot.model->joints();
  VecX values(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j)
    values[static_cast<Eigen::Index>(j)] = joints[j].gains.*gain;
  return values;
}

std::tuple<VecX, VecX, VecX> servo_command_of(const Robot& robot, const JointTarget& target, double to_end) {
  const Eigen::Index n = robot.model->nv() - 6;
  if (target.q.size() != n) {
    throw InputError(fmt::format("target: has {} joints; must have the {} of robot {}", target.q.size(), n,
                                 robot.model->profile().name));
  }
  if (!std::isfinite(to_end)) throw InputError(fmt::format("to_end {}: must be finite", to_end));
  VecX q(n), dq(n), tau(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const ServoCommand command = servo_command(*robot.model, static_cast<std::size_t>(j), target, to_end);
    q[j] = command.q;
    dq[j] = command.dq;
    tau[j] = command.tau;
  }
  return {std::move(q), std::move(dq), std::move(tau)};
}

}  // namespace

Robot robot_of(nb::handle given) {
  Robot robot;
  if (nb::try_cast(given, robot)) return robot;
  return load(name_or_path("robot", given), std::nullopt);
}

void bind_robot(nb::module_& m) {
  nb::class_<Joint>(m, "Joint", "A hinge joint with its motor. rad, N·m, seconds.")
      .def_ro("name", &Joint::name)
      .def_prop_ro("lower", [](const Joint& joint) { return joint.position.lo; })
      .def_prop_ro("upper", [](const Joint& joint) { return joint.position.hi; })
      .def_ro("home", &Joint::home,
              "In the pose that the robot begins in, of a joint of an arm, the waist or the neck.")
      .def_ro("speed", &Joint::speed, "Largest speed of a planned motion [rad/s].")
      .def_prop_ro(
          "torque", [](const Joint& joint) { return joint.motor.stall; }, "Stall torque [N·m].")
      .def("__repr__", [](const Joint& joint) {
        return fmt::format("Joint({:?}, {:.3g}…{:.3g} rad)", joint.name, joint.position.lo, joint.position.hi);
      });

  nb::class_<Robot>(m, "Robot",
                    "A robot: a name that `baton.robots()` lists, or the file of a profile (.toml) or of a model (.xml "
                    "of MuJoCo, .urdf).\n\n"
                    "Configurations `q` (nq = 7 + n) are the first body's position 3 [m] and quaternion 4 (w first) in "
                    "the world, then the n joint angles [rad] in the order of `joints`.")
      .def(
          "__init__",
          [](Robot* self, const nb::object& name_or_file, const std::optional<std::string>& drive) {
            new (self) Robot(load(name_or_path("robot", name_or_file), drive));
          },
          nb::arg("robot") = "mighty", nb::kw_only(), nb::arg("drive") = nb::none(),
          nb::sig("def __init__(self, robot: str | os.PathLike = 'mighty', *, drive: str | None = None) -> None"),
          "Load a robot.\n\n"
          "drive: kind of servos in place of the profile's: 'torque', 'pd' or 'stiff'.\n"
          "Raises InputError: it cannot be read or is not a humanoid; the message says why.")
      .def_prop_ro("name", [](const Robot& r) { return r.model->profile().name; })
      .def_prop_ro(
          "nq", [](const Robot& r) { return r.model->nq(); }, "Length of a configuration, 7 + n.")
      .def_prop_ro(
          "mass", [](const Robot& r) { return r.model->mass(); }, "[kg]")
      .def_prop_ro(
          "com_height", [](const Robot& r) { return r.model->profile().stance.com_height; },
          "Height of the centre of mass above the soles when it stands [m].")
      .def_prop_ro(
          "period", [](const Robot& r) { return r.model->profile().tick.period; }, "Length of a tick [s].")
      .def_prop_ro("joints", [](const Robot& r) { return r.model->joints(); })
      .def_prop_ro("drive", [](const Robot& r) { return std::string(to_string(r.model->profile().drive)); })
      .def_prop_ro(
          "kp", [](const Robot& r) { return gains(r, &Profile::Gains::kp); }, "Of the servos (n) [N·m/rad].")
      .def_prop_ro(
          "kd", [](const Robot& r) { return gains(r, &Profile::Gains::kd); }, "Of the servos (n) [N·m·s/rad].")
      .def(
          "standing",
          [](const Robot& r, const nb::object& world) {
            const OwnMujoco own;
            return stand(*r.model, World::load(name_or_path("world", world)).site("start"),
                         r.model->profile().stance.com_height)
                .q;
          },
          nb::arg("world") = "flat",
          nb::sig("def standing(self, world: str | os.PathLike = 'flat') -> numpy.typing.NDArray[numpy.float64]"),
          "The configuration (nq) in which a run begins in a world.")
      .def(
          "mjcf",
          [](const Robot& r, const nb::object& world, double timestep) {
            if (!(timestep >= 1e-5 && timestep <= 0.1))
              throw InputError(fmt::format("timestep {}: must be 1e-5 … 0.1 s", timestep));
            const OwnMujoco own;
            return World::load(name_or_path("world", world)).compose(*r.model, timestep);
          },
          nb::arg("world") = "flat", nb::arg("timestep") = 0.001,
          nb::sig("def mjcf(self, world: str | os.PathLike = 'flat', timestep: float = 0.001) -> str"),
          "Robot and world as one MuJoCo model (MJCF text), with a torque motor of its name at each joint, and sites "
          "for "
          "the parts that the profile names (mighty: 'imu', 'left_sole', 'right_sole', 'left_hand', 'right_hand'). "
          "`timestep` in s.")
      .def("servo_command", &servo_command_of, nb::arg("target"), nb::arg("to_end") = 0.0,
           "What to send to the servos for a target: angles [rad], speeds [rad/s] and feed-forward torques [N·m], (n) "
           "each.\n\n"
           "A servo gives tau + kp * (q - measured angle) + kd * (dq - measured speed).\n"
           "to_end: time until the end of the tick, for servos that are told more often [s].")
      .def("__repr__", [](const Robot& r) {
        return fmt::format("Robot({:?}, {} joints, {:.4g} kg)", r.model->profile().name, r.model->joints().size(),
                           r.model->mass());
      });
}

}  // namespace baton::python
