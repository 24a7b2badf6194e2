#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <utility>

#include "baton/proving/scenario.hpp"
#include "baton/run/planning_thread.hpp"
#include "baton/run/simulation.hpp"
#include "events.hpp"

namespace baton::python {
namespace {

constexpr int kTicksBetweenSignals = 20;  ///< ticks after which `advance` looks whether it was interrupted

/// The value of that name.
/// @throws InputError no such name
template <typename Value, std::size_t n>
Value choice(const char* option, const std::string& name, const std::array<std::pair<const char*, Value>, n>& values) {
  std::array<const char*, n> names{};
  for (std::size_t i = 0; i < n; ++i) {
    if (name == values[i].first) return values[i].second;
    names[i] = values[i].first;
  }
  throw InputError(fmt::format("{} {:?}: must be one of {}", option, name, fmt::join(names, ", ")));
}

/// A robot that a Python object is: it has `read()` and `write(target)`, and perhaps `reset()`.
class PythonRobot : public baton::Robot {
 public:
  explicit PythonRobot(nb::object object) : object_(std::move(object)) {
    for (const char* method : {"read", "write"}) {
      if (!nb::hasattr(object_, method)) {
        throw InputError(
            fmt::format("on: {} has no method {}; must be 'sim', 'ideal' or an object with read() and "
                        "write(target)",
                        nb::repr(object_).c_str(), method));
      }
    }
  }
  ~PythonRobot() override {
    const nb::gil_scoped_acquire gil;
    object_.reset();
  }
  PythonRobot(const PythonRobot&) = delete;
  PythonRobot& operator=(const PythonRobot&) = delete;

  Measurement read() override {
    const nb::gil_scoped_acquire gil;
    const nb::object answer = object_.attr("read")();
    Measurement measurement;
    if (!nb::try_cast(answer, measurement)) {
      throw InputError(fmt::format("read() of {} gave {}; must give a baton.Measurement", nb::repr(object_).c_str(),
                                   nb::repr(answer).c_str()));
    }
    return measurement;
  }
  void write(const JointTarget& target) override {
    const nb::gil_scoped_acquire gil;
    object_.attr("write")(nb::cast(target, nb::rv_policy::copy));
  }
  void reset() override {
    const nb::gil_scoped_acquire gil;
    if (!nb::hasattr(object_, "reset")) throw InputError("this robot has no method reset()");
    object_.attr("reset")();
  }

 private:
  nb::object object_;
};

struct Options {
  std::string plant, state, gait, duration, on_limit;
  std::optional<std::string> scenario;
  double times = 1.0;
  std::uint64_t seed = 0;
  bool live = false;
};

/// A robot that is guided, in a world.
class Run : public Sink {
 public:
  Run(const Robot& robot, const std::string& world, const nb::object& on, const Options& o)
      : robot_(robot), world_(World::load(world)) {
    const Modes modes{
        choice("duration", o.duration,
               std::array{std::pair("paper", DurationRule::paper), std::pair("search", DurationRule::search)}),
        choice("on_limit", o.on_limit,
               std::array{std::pair("shrink", OnLimit::shrink), std::pair("discard", OnLimit::discard)}),
        choice("gait", o.gait, std::array{std::pair("flow", Gait::flow), std::pair("stop", Gait::stop)})};
    const StateSource source =
        choice("state", o.state,
               std::array{std::pair("sensors", StateSource::sensors), std::pair("torques", StateSource::torques),
                          std::pair("perfect", StateSource::perfect)});
    std::string name;
    const bool named = nb::try_cast(on, name);
    const Scenario* scenario = o.scenario ? &scenario_named(*o.scenario) : nullptr;
    if (scenario != nullptr && (!named || name != "sim"))
      throw InputError("scenario: must be on='sim', it needs physics");
    if (scenario != nullptr) {
      const Drive drive = drive_of(*scenario, *robot_.model);
      if (drive != robot_.model->profile().drive)
        robot_.model = std::make_shared<const RobotModel>(with_drive(*robot_.model, drive));
    }
    const RobotModel& model = *robot_.model;
    if (o.live) planning_ = std::make_unique<PlanningThread>(model, world_, modes);
    const Session::Parameters session{modes, source, planning_.get()};
    if (named) {
      const bool real = choice("plant", o.plant, std::array{std::pair("real", true), std::pair("model", false)});
      Simulation::Parameters parameters{.session = session};
      const Simulation::On where = choice(
          "on", name, std::array{std::pair("sim", Simulation::On::sim), std::pair("ideal", Simulation::On::ideal)});
      if (where == Simulation::On::sim) parameters.physics.plant = plant_of(real, scenario, model, o.seed, o.times);
      simulation_ = std::make_unique<Simulation>(model, world_, where, parameters);
    } else {
      theirs_ = std::make_unique<PythonRobot>(on);
      const Posture start = stand(model, world_.site("start"), model.profile().stance.com_height);
      on_theirs_ = std::make_unique<Session>(model, world_, *theirs_, start, session);
    }
    kinematics_ = std::make_unique<Kinematics>(model);
    session_ = named ? &simulation_->session() : on_theirs_.get();
    session_->add(*this);
  }

  void on_tick(const TickRecord& record) override {
    measurement_ = record.measurement;
    target_ = record.target;
    for (const Event& event : record.navigator.events())
      events_.push_back(event_of(event, record.t, record.navigator));
  }

  std::vector<PythonEvent> step(const std::optional<Command>& command) {
    if (command) command_ = *command;
    const nb::gil_scoped_release released;
    session_->step(command_);
    return std::exchange(events_, {});
  }

  std::vector<PythonEvent> advance(double seconds) {
    if (!std::isfinite(seconds) || seconds < 0.0)
      throw InputError(fmt::format("seconds {}: must be 0 or more, and finite", seconds));
    const double period = robot_.model->profile().tick.period;
    const auto ticks = static_cast<long>(std::lround(seconds / period));
    for (long tick = 0; tick < ticks; ++tick) {
      if (tick % kTicksBetweenSignals == 0 && PyErr_CheckSignals() != 0) throw nb::python_error();
      const nb::gil_scoped_release released;
      session_->step(command_);
    }
    return std::exchange(events_, {});
  }

  void guide(const std::string& part, const nb::object& axes, std::optional<double> lift) {
    Command next = command_;
    next.guide = part_named(part);
    next.axes = axes.is_none() ? Vec6::Zero().eval() : numbers<Vec6>("axes", axes);
    next.recall = Recall::none;
    if (lift) {
      if (!is_foot(next.guide)) throw InputError(fmt::format("lift of {}: only a foot has a lever", part));
      next.lift[side_of(next.guide)] = *lift;
    }
    command_ = next;
  }
  void recall(Recall recall) { command_.recall = recall; }
  void release() {
    command_.axes.setZero();
    command_.recall = Recall::none;
  }

  void reset() {
    session_->reset();
    session_->add(*this);
    command_ = {};
    measurement_.reset();
    target_.reset();
    events_.clear();
  }

  [[nodiscard]] const Session& session() const { return *session_; }
  [[nodiscard]] const Robot& robot() const { return robot_; }
  [[nodiscard]] const std::string& world() const { return world_.name(); }
  [[nodiscard]] const Command& command() const { return command_; }
  [[nodiscard]] const std::optional<Measurement>& measurement() const { return measurement_; }
  [[nodiscard]] const std::optional<JointTarget>& target() const { return target_; }
  [[nodiscard]] std::optional<Truth> truth() const {
    const Truth* truth = session_->truth();
    return truth != nullptr ? std::optional(*truth) : std::nullopt;
  }
  [[nodiscard]] std::string mjcf() const {
    if (!simulation_) throw InputError("mjcf: only of a robot on 'sim' or 'ideal'");
    return simulation_->model_text();
  }
  [[nodiscard]] VecX qpos() const {
    SimulatedRobot* const simulated = simulation_ ? simulation_->simulated() : nullptr;
    if (simulated == nullptr) throw InputError("qpos: only of a robot on 'sim'");
    return Eigen::Map<const VecX>(simulated->data().qpos, simulated->model().nq);
  }

  /// Estimated pose of a part in the world, as a homogeneous matrix.
  [[nodiscard]] Eigen::Matrix4d pose(const std::string& name) {
    const Part part = part_named(name);
    const Navigator& navigator = session_->navigator();
    if (!measurement_) throw InputError("pose: nothing is known before the first step");
    kinematics_->set(navigator.state().q);
    const Pose pose = navigator.anchor() * (part == Part::trunk ? kinematics_->trunk()
                                            : is_foot(part)     ? kinematics_->sole(side_of(part))
                                                                : kinematics_->hand(side_of(part)));
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = pose.R;
    matrix.topRightCorner<3, 1>() = pose.p;
    return matrix;
  }
  /// Estimated COM in the world [m].
  [[nodiscard]] Vec3 com() const {
    if (!measurement_) throw InputError("com: nothing is known before the first step");
    return session_->navigator().anchor() * session_->navigator().state().com;
  }

 private:
  Robot robot_;
  World world_;
  std::unique_ptr<Planning> planning_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<PythonRobot> theirs_;
  std::unique_ptr<Session> on_theirs_;
  std::unique_ptr<Kinematics> kinematics_;
  Session* session_ = nullptr;
  Command command_;
  std::optional<Measurement> measurement_;
  std::optional<JointTarget> target_;
  std::vector<PythonEvent> events_;
};

}  // namespace

void bind_run(nb::module_& m) {
  nb::class_<Run>(
      m, "Run",
      "A robot that is guided in a world, tick by tick. The same seed and commands give the same run, bit by "
      "bit. Not for use by several threads at once.")
      .def(
          "__init__",
          [](Run* self, const Robot& robot, const std::string& world, const nb::object& on, const std::string& plant,
             std::uint64_t seed, const std::optional<std::string>& scenario, double times, const std::string& state,
             const std::string& gait, const std::string& duration, const std::string& on_limit, bool live) {
            new (self) Run(robot, world, on, {plant, state, gait, duration, on_limit, scenario, times, seed, live});
          },
          nb::arg("robot"), nb::arg("world") = "flat", nb::kw_only(), nb::arg("on") = "sim", nb::arg("plant") = "real",
          nb::arg("seed") = 0, nb::arg("scenario") = nb::none(), nb::arg("times") = 1.0, nb::arg("state") = "sensors",
          nb::arg("gait") = "flow", nb::arg("duration") = "paper", nb::arg("on_limit") = "shrink",
          nb::arg("live") = false,
          "world: a name in worlds/ or a file.\n"
          "on: 'sim' (physics), 'ideal' (joints do what they are told), or a robot of yours: an object with\n"
          "  read() → Measurement, and write(JointTarget), which lets a tick pass; reset() if it can. It must begin "
          "in\n"
          "  Robot.standing(world).\n"
          "plant: errors of simulated sensors and motors: 'real' (as the profile says, drawn by `seed`) or 'model' "
          "(none).\n"
          "scenario, times: a disturbance of docs/balance.md on top, and how many times as large.\n"
          "state, gait, duration, on_limit: as the options of `baton drive`.\n"
          "live: plan on a thread of its own, for real time: a plan that is late is dropped. Else planning takes "
          "place\n"
          "  within a step.\n"
          "Raises InputError.")
      .def("step", &Run::step, nb::arg("command") = nb::none(),
           "Let one tick pass. `command` holds until another is given. Returns what happened, as events.")
      .def("advance", &Run::advance, nb::arg("seconds"), "Let time pass [s]. Returns what happened, as events.")
      .def("guide", &Run::guide, nb::arg("part"), nb::arg("axes") = nb::none(), nb::kw_only(),
           nb::arg("lift") = nb::none(),
           nb::sig(
               "def guide(self, part: str, axes: numpy.typing.ArrayLike | None = None, *, lift: float | None = None) "
               "-> None"),
           "Hold the stick: the guided part, the axes as in Command (None: centred), and the lever of a guided foot, "
           "which else stays where it was. A foot that is not guided any more is put down.")
      .def("release", &Run::release, "Let go of the stick; levers stay.")
      .def(
          "retrace", [](Run& run) { run.recall(Recall::retrace); }, "Go back the way it came, until told otherwise.")
      .def(
          "home", [](Run& run) { run.recall(Recall::home); }, "Step to the stance that it began in, wherever it is.")
      .def(
          "stop", [](Run& run) { run.recall(Recall::stop); }, "Come to rest as soon as possible.")
      .def("reset", &Run::reset, "Begin anew: the same commands give the same run again.")
      .def_prop_ro(
          "t", [](const Run& run) { return run.session().t(); }, "[s]")
      .def_prop_ro("resting", [](const Run& run) { return run.session().resting(); })
      .def_prop_ro(
          "fallen",
          [](const Run& run) { return run.session().fallen() || run.session().navigator().guard() == Guard::fallen; })
      .def_prop_ro(
          "guard", [](const Run& run) { return std::string(to_string(run.session().navigator().guard())); },
          "'armed', 'lifted', 'fallen' or 'stood_up'.")
      .def_prop_ro(
          "phase", [](const Run& run) { return std::string(to_string(run.session().navigator().phase())); },
          "Planned contacts: 'hold', 'double', 'single_left', 'single_right' or 'fallen'.")
      .def_prop_ro("robot", &Run::robot)
      .def_prop_ro("world", &Run::world)
      .def_prop_ro("command", &Run::command, nb::rv_policy::copy)
      .def_prop_ro("measurement", &Run::measurement, nb::rv_policy::copy, "What the last tick began with.")
      .def_prop_ro("target", &Run::target, nb::rv_policy::copy, "What the joints were told in the last tick.")
      .def_prop_ro("truth", &Run::truth, "None if the robot is yours.")
      .def_prop_ro("com", &Run::com, "Estimated centre of mass in the world (3) [m].")
      .def("pose", &Run::pose, nb::arg("part"),
           "Estimated pose of a part in the world: homogeneous matrix (4, 4); of a foot, of its sole.")
      .def_prop_ro("mjcf", &Run::mjcf, "The simulated model as MJCF text, plant and scenario included.")
      .def_prop_ro("qpos", &Run::qpos, "Its configuration in physics, to be drawn with `mjcf`.")
      .def("__repr__", [](const Run& run) {
        return fmt::format("Run({:?} in {:?}, t={:.3f})", run.robot().model->profile().name, run.world(),
                           run.session().t());
      });
}

}  // namespace baton::python
