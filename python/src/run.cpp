#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>
#include <utility>

#include "baton/ik/stand.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/run/planning_thread.hpp"
#include "baton/run/simulation.hpp"
#include "events.hpp"

namespace baton::python {
namespace {

constexpr int kTicksBetweenSignals = 20;  ///< ticks after which `advance` looks whether it was interrupted
constexpr double kMostTimes = 100.0;      ///< largest factor on a scenario
constexpr double kLongest = 1e6;          ///< that `advance` takes at once [s]

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

/// A robot that a Python object is: it has `read()` and `write(target)`, and perhaps `reset()`. Made and destroyed with
/// the GIL; its calls acquire it.
class PythonRobot : public baton::Robot {
 public:
  /// @throws InputError the object lacks a method, or cannot give what `source` needs
  PythonRobot(nb::object object, StateSource source) : object_(std::move(object)), source_(source) {
    for (const char* method : {"read", "write"}) {
      if (!nb::hasattr(object_, method)) {
        throw InputError(
            fmt::format("on {}: has no method {}; must be 'sim', 'ideal' or an object with read() and "
                        "write(target)",
                        nb::repr(object_).c_str(), method));
      }
    }
    if (source == StateSource::perfect)
      throw InputError("state \"perfect\": must be sensors or torques, as a robot of yours has no truth");
  }

  Measurement read() override {
    const Back back;
    const nb::object answer = object_.attr("read")();
    Measurement measurement;
    if (!nb::try_cast(answer, measurement)) {
      throw InputError(fmt::format("read() of {} gave {}; must give a baton.Measurement", nb::repr(object_).c_str(),
                                   nb::repr(answer).c_str()));
    }
    check_complete(measurement);
    first_ = false;
    return measurement;
  }
  void write(const JointTarget& target) override {
    const Back back;
    object_.attr("write")(nb::cast(target, nb::rv_policy::copy));
  }
  void reset() override {
    const Back back;
    if (!nb::hasattr(object_, "reset")) throw InputError("this robot has no method reset()");
    object_.attr("reset")();
    first_ = true;
  }

  [[nodiscard]] PyObject* object() const { return object_.ptr(); }
  void forget() { object_ = nb::none(); }

 private:
  /// @throws InputError what tells the loads is missing: the robot would seem to hang in the air
  void check_complete(const Measurement& measurement) const {
    if (source_ == StateSource::torques && measurement.torque.size() == 0)
      throw InputError("state \"torques\": the measurement has no motor torques (torque)");
    if (first_ && source_ == StateSource::sensors && measurement.sole.left == Wrench{} &&
        measurement.sole.right == Wrench{}) {
      throw InputError(
          "state \"sensors\": the measurement has no forces under the soles (left_sole, right_sole); without such "
          "sensors, state must be torques");
    }
  }

  nb::object object_;
  StateSource source_;
  bool first_ = true;
};

struct Options {
  std::string state, gait, duration, on_limit;
  std::optional<std::string> plant, scenario;
  double times = 1.0;
  std::uint64_t seed = 0;
  bool live = false;
};

/// The scenario of that name; null without one.
/// @throws InputError no such scenario, or `times` does not go with it
const Scenario* scenario_in(const Options& o) {
  if (!(o.times > 0.0 && o.times <= kMostTimes))
    throw InputError(fmt::format("times {}: must be above 0, and at most {}", o.times, kMostTimes));
  if (!o.scenario) {
    if (o.times != 1.0) throw InputError(fmt::format("times {}: needs a scenario", o.times));
    return nullptr;
  }
  const auto found = std::ranges::find(scenarios(), *o.scenario, &Scenario::name);
  if (found == scenarios().end()) {
    std::vector<std::string_view> names;
    for (const Scenario& scenario : scenarios())
      names.push_back(scenario.name);
    throw InputError(fmt::format("scenario {:?}: must be one of {}", *o.scenario, fmt::join(names, ", ")));
  }
  if (found->deviate == nullptr && o.times != 1.0)
    throw InputError(fmt::format("times {}: the scenario {} has no size that could be scaled", o.times, found->name));
  return &*found;
}

World load_world(const std::string& name_or_file) {
  const OwnMujoco own;
  return World::load(name_or_file);
}

/// A robot that is guided, in a world. All is called with the GIL, and by one thread at a time, which is checked.
class Run : public Sink {
 public:
  Run(const Robot& robot, const std::string& world, const nb::object& on, const Options& o)
      : robot_(robot), world_(load_world(world)) {
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
    const bool real =
        choice("plant", o.plant.value_or("real"), std::array{std::pair("real", true), std::pair("model", false)});
    const Scenario* scenario = scenario_in(o);
    std::optional<Simulation::On> where;
    std::string name;
    if (nb::try_cast(on, name)) {
      where = choice("on", name,
                     std::array{std::pair("sim", Simulation::On::sim), std::pair("ideal", Simulation::On::ideal)});
    } else {
      theirs_ = std::make_unique<PythonRobot>(on, source);
    }
    if (where != Simulation::On::sim && (scenario != nullptr || o.plant)) {
      throw InputError(
          fmt::format("{}: must be on='sim', it needs physics", scenario != nullptr ? "scenario" : "plant"));
    }
    const Away away;
    if (scenario != nullptr) {
      const Drive drive = drive_of(*scenario, *robot_.model);
      if (drive != robot_.model->profile().drive)
        robot_.model = std::make_shared<const RobotModel>(with_drive(*robot_.model, drive));
    }
    const RobotModel& model = *robot_.model;
    if (o.live) planning_ = std::make_unique<PlanningThread>(model, world_, modes);
    const Session::Parameters session{modes, source, planning_.get()};
    if (where) {
      Simulation::Parameters parameters{.session = session};
      if (where == Simulation::On::sim) parameters.physics.plant = plant_of(real, scenario, model, o.seed, o.times);
      simulation_ = std::make_unique<Simulation>(model, world_, *where, parameters);
    } else {
      const Posture start = stand(model, world_.site("start"), model.profile().stance.com_height);
      on_theirs_ = std::make_unique<Session>(model, world_, *theirs_, start, session);
    }
    kinematics_ = std::make_unique<Kinematics>(model);
    session_ = where ? &simulation_->session() : on_theirs_.get();
    session_->add(*this);
  }

  void on_tick(const TickRecord& record) override {
    measurement_ = record.measurement;
    target_ = record.target;
    for (const Event& event : record.navigator.events())
      events_.push_back(event_of(event, record.t, record.navigator));
  }

  std::vector<PythonEvent> step(const std::optional<Command>& command) {
    const Use use(*this);
    if (command) command_ = *command;
    tick();
    return std::exchange(events_, {});
  }

  std::vector<PythonEvent> advance(double seconds) {
    if (!(seconds >= 0.0 && seconds <= kLongest))
      throw InputError(fmt::format("seconds {}: must be 0 … {}", seconds, kLongest));
    const Use use(*this);
    const double half = 0.5 * robot_.model->profile().tick.period;
    if (std::abs(session_->t() - until_) > 1.1 * half) until_ = session_->t();  // by steps, or after an exception
    until_ += seconds;
    for (long count = 0; session_->t() < until_ - half; ++count) {
      if (count % kTicksBetweenSignals == 0 && PyErr_CheckSignals() != 0) throw nb::python_error();
      tick();
    }
    return std::exchange(events_, {});
  }

  void reset() {
    const Use use(*this);
    {
      const Away away;
      session_->reset();
    }
    session_->add(*this);
    command_ = {};
    until_ = 0.0;
    measurement_.reset();
    target_.reset();
    events_.clear();
  }

  void guide(const std::string& part, const nb::object& axes, std::optional<double> lift) {
    Command next = command();
    next.guide = part_named(part);
    next.axes = axes.is_none() ? Vec6::Zero().eval() : numbers<Vec6>("axes", axes);
    next.recall = Recall::none;
    if (lift) {
      if (!is_foot(next.guide)) throw InputError(fmt::format("lift of {}: only a foot has a lever", part));
      next.lift[side_of(next.guide)] = *lift;
    }
    command_ = next;
  }
  void drive_arms(const std::vector<std::string>& joints, const nb::object& t, const nb::object& q) {
    const Use use(*this);
    ArmTargets targets{joints, {}, numbers<MatX>("q", q)};
    const auto times = numbers<VecX>("t", t);
    targets.t.assign(times.begin(), times.end());
    if (targets.t.empty()) throw InputError("t has no times; release_arms() lets go of the arms");
    session_->drive_arms(targets);
  }
  void release_arms(const std::optional<std::vector<std::string>>& joints) {
    const Use use(*this);
    session_->drive_arms(joints ? ArmTargets{*joints, {}, {}} : released_arms(*robot_.model));
  }
  void recall(Recall recall) {
    check_thread();
    command_.recall = recall;
  }
  void release() {
    check_thread();
    command_.axes.setZero();
    command_.recall = Recall::none;
  }

  [[nodiscard]] const Session& session() const {
    check_thread();
    return *session_;
  }
  [[nodiscard]] const Robot& robot() const { return robot_; }
  [[nodiscard]] const std::string& world() const { return world_.name(); }
  [[nodiscard]] const Command& command() const {
    check_thread();
    return command_;
  }
  [[nodiscard]] const std::optional<Measurement>& measurement() const {
    check_thread();
    return measurement_;
  }
  [[nodiscard]] const std::optional<JointTarget>& target() const {
    check_thread();
    return target_;
  }
  [[nodiscard]] std::optional<Truth> truth() const {
    const Truth* truth = session().truth();
    return truth != nullptr ? std::optional(*truth) : std::nullopt;
  }
  [[nodiscard]] std::optional<std::string> mjcf() const {
    check_thread();
    if (!simulation_) return std::nullopt;
    const OwnMujoco own;
    return simulation_->model_text();
  }
  [[nodiscard]] std::optional<VecX> qpos() const {
    check_thread();
    SimulatedRobot* const simulated = simulation_ ? simulation_->simulated() : nullptr;
    if (simulated == nullptr) return std::nullopt;
    return Eigen::Map<const VecX>(simulated->data().qpos, simulated->model().nq);
  }

  /// Estimated pose of a part in the world, as a homogeneous matrix.
  [[nodiscard]] Eigen::Matrix4d pose(const std::string& name) {
    const Part part = part_named(name);
    place();
    const Pose pose = session_->navigator().anchor() * (part == Part::trunk ? kinematics_->trunk()
                                                        : is_foot(part)     ? kinematics_->sole(side_of(part))
                                                                            : kinematics_->hand(side_of(part)));
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = pose.R;
    matrix.topRightCorner<3, 1>() = pose.p;
    return matrix;
  }
  /// Estimated COM in the world [m].
  [[nodiscard]] Vec3 com() {
    place();
    return session_->navigator().anchor() * kinematics_->com();
  }

  [[nodiscard]] PythonRobot* theirs() const { return theirs_.get(); }

 private:
  /// Takes the run for the time of a call.
  class Use {
   public:
    /// @throws std::runtime_error it is taken
    explicit Use(Run& run) : run_(&run) {
      run.check_thread();
      if (run.user_ != std::thread::id{})
        throw std::runtime_error("this run is in a step: read() and write() of its robot cannot step or reset it");
      run.user_ = std::this_thread::get_id();
    }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { run_->user_ = {}; }

   private:
    Run* run_;
  };

  /// @throws std::runtime_error another thread is in a step
  void check_thread() const {
    if (user_ != std::thread::id{} && user_ != std::this_thread::get_id())
      throw std::runtime_error("this run is in a step of another thread: a run is for one thread at a time");
  }
  void tick() {
    const Away away;
    session_->step(command_);
  }
  /// Sets the kinematics to the estimated state, or, before the first step, to the start.
  void place() {
    const Navigator& navigator = session().navigator();
    kinematics_->set(measurement_ ? navigator.state().q : navigator.sample().q);
  }

  std::thread::id user_;  ///< thread that is in a step
  double until_ = 0.0;    ///< time that `advance` was told to reach [s]
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

// For the garbage collector: a robot of the user's may know its run.
int visit_run(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  const PythonRobot* theirs = nb::inst_ready(self) ? nb::inst_ptr<Run>(self)->theirs() : nullptr;
  if (theirs != nullptr) Py_VISIT(theirs->object());
  return 0;
}
int clear_run(PyObject* self) {
  PythonRobot* theirs = nb::inst_ready(self) ? nb::inst_ptr<Run>(self)->theirs() : nullptr;
  if (theirs != nullptr) theirs->forget();
  return 0;
}
std::array<PyType_Slot, 3> run_slots{{{Py_tp_traverse, reinterpret_cast<void*>(visit_run)},
                                      {Py_tp_clear, reinterpret_cast<void*>(clear_run)},
                                      {0, nullptr}}};

nb::dict described_scenarios() {
  nb::dict all;
  for (const Scenario& scenario : scenarios())
    all[nb::cast(std::string(scenario.name))] = std::string(scenario.what);
  return all;
}

}  // namespace

void bind_run(nb::module_& m) {
  m.def("scenarios", &described_scenarios, nb::sig("def scenarios() -> dict[str, str]"),
        "The disturbances that `Run` knows by name, and what each is, with numbers for mighty.");
  nb::class_<Run>(
      m, "Run",
      "A robot that is guided in a world, tick by tick. The same seed and commands give the same run, bit by "
      "bit, unless it is live or the robot is yours. For one thread at a time; others run meanwhile.",
      nb::type_slots(run_slots.data()))
      .def(
          "__init__",
          [](Run* self, const nb::object& robot, const nb::object& world, const nb::object& on,
             const std::optional<std::string>& plant, std::int64_t seed, const std::optional<std::string>& scenario,
             double times, const std::string& state, const std::string& gait, const std::string& duration,
             const std::string& on_limit, bool live) {
            if (seed < 0) throw InputError(fmt::format("seed {}: must be 0 or more", seed));
            new (self)
                Run(robot_of(robot), name_or_path("world", world), on,
                    {state, gait, duration, on_limit, plant, scenario, times, static_cast<std::uint64_t>(seed), live});
          },
          nb::arg("robot") = "mighty", nb::arg("world") = "flat", nb::kw_only(), nb::arg("on") = "sim",
          nb::arg("plant") = nb::none(), nb::arg("seed") = 0, nb::arg("scenario") = nb::none(), nb::arg("times") = 1.0,
          nb::arg("state") = "sensors", nb::arg("gait") = "flow", nb::arg("duration") = "paper",
          nb::arg("on_limit") = "shrink", nb::arg("live") = false,
          nb::sig(
              "def __init__(self, robot: Robot | str | os.PathLike = 'mighty', world: str | os.PathLike = 'flat', *, "
              "on: object = 'sim', plant: str | None = None, seed: int = 0, scenario: str | None = None, times: "
              "float = 1.0, state: str = 'sensors', gait: str = 'flow', duration: str = 'paper', on_limit: str = "
              "'shrink', live: bool = False) -> None"),
          "robot: a Robot, or what one is made of.\n"
          "world: 'flat', 'room', or a file.\n"
          "on: 'sim' (physics), 'ideal' (joints do what they are told), or a robot of yours: an object with\n"
          "  read() → Measurement, and write(JointTarget), which lets a tick pass; reset() if it can. It must begin "
          "in\n"
          "  Robot.standing(world).\n"
          "plant: errors of simulated sensors and motors: 'real' (as the profile says, drawn by `seed`; the default)\n"
          "  or 'model' (none).\n"
          "seed: of plant and scenario, 0 or more.\n"
          "scenario, times: a disturbance that `scenarios()` lists, on top, and how many times as large.\n"
          "state: what the robot's state comes from: 'sensors' (encoders, IMU, forces under the soles), 'torques'\n"
          "  (motor torques in place of those forces) or 'perfect' (the simulator).\n"
          "gait: 'flow' (motions are replaced on their way) or 'stop' (only at rest).\n"
          "duration: of a motion: 'paper' (the first feasible of a series) or 'search' (the shortest feasible).\n"
          "on_limit: what is done with a command that is not feasible: 'shrink' (a part of it) or 'discard'.\n"
          "live: plan on a thread of its own, for real time: a plan that is late is dropped. Else planning takes "
          "place\n"
          "  within a step.\n"
          "Raises InputError.")
      .def("step", &Run::step, nb::arg("command") = nb::none(),
           "Let one tick pass. `command` holds until another is given. Returns what happened, as events.")
      .def("advance", &Run::advance, nb::arg("seconds"),
           "Let time pass [s], in whole ticks: what is left of one counts the next time. Returns what happened, as "
           "events. After an exception, Ctrl-C's too, the run can go on; the events so far are returned next.")
      .def("guide", &Run::guide, nb::arg("part"), nb::arg("axes") = nb::none(), nb::kw_only(),
           nb::arg("lift") = nb::none(),
           nb::sig(
               "def guide(self, part: str, axes: numpy.typing.ArrayLike | None = None, *, lift: float | None = None) "
               "-> None"),
           "Hold the stick: the guided part, the axes as in Command (None: centred), and the lever of a guided foot, "
           "which else stays where it was. A foot that is not guided any more is put down, and lifted again when it is "
           "guided with its lever up.")
      .def(
          "drive_arms", &Run::drive_arms, nb::arg("joints"), nb::arg("t"), nb::arg("q"),
          nb::sig("def drive_arms(self, joints: collections.abc.Sequence[str], t: numpy.typing.ArrayLike, q: "
                  "numpy.typing.ArrayLike) -> None"),
          "Drive joints of the arms, whatever the stick does meanwhile, from the next motion on.\n"
          "joints: names of joints of the arms (n).\n"
          "t: times at which they are to be there, in the time of the run, increasing (k) [s]. What is known a second\n"
          "  ahead is followed without delay; what is to be now, as soon as it can be.\n"
          "q: their angles (k, n) [rad]. They replace what was given for these joints from t[0] on. After the last "
          "time\n"
          "  the joints stay where they are then.\n"
          "Speed and acceleration are limited, and what comes too close to something is done in part: `ArmsRefused`.\n"
          "Raises InputError.")
      .def("release_arms", &Run::release_arms, nb::arg("joints") = nb::none(),
           nb::sig("def release_arms(self, joints: collections.abc.Sequence[str] | None = None) -> None"),
           "Let go of these joints of the arms, or of all (None): they come to rest.")
      .def("release", &Run::release, "Let go of the stick; levers stay.")
      .def(
          "retrace", [](Run& run) { run.recall(Recall::retrace); }, "Go back the way it came, until told otherwise.")
      .def(
          "home", [](Run& run) { run.recall(Recall::home); }, "Step to the stance that it began in, wherever it is.")
      .def(
          "stop", [](Run& run) { run.recall(Recall::stop); }, "Come to rest as soon as possible.")
      .def("reset", &Run::reset, "Begin anew.")
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
      .def_prop_ro("measurement", &Run::measurement, nb::rv_policy::copy,
                   "What the last tick began with; None before the first.")
      .def_prop_ro("target", &Run::target, nb::rv_policy::copy,
                   "What the joints were told in the last tick; None before the first.")
      .def_prop_ro("truth", &Run::truth, "None if the robot is yours.")
      .def_prop_ro("com", &Run::com, "Estimated centre of mass in the world (3) [m].")
      .def("pose", &Run::pose, nb::arg("part"),
           "Estimated pose of a part in the world: homogeneous matrix (4, 4); of a foot, of its sole.")
      .def_prop_ro("mjcf", &Run::mjcf,
                   "The simulated model as MJCF text, plant and scenario included. None if the robot is yours.")
      .def_prop_ro("qpos", &Run::qpos, "Its configuration in physics, to be drawn with `mjcf`. None unless on 'sim'.")
      .def("__repr__", [](const Run& run) {
        return fmt::format("Run({:?} in {:?})", run.robot().model->profile().name, run.world());
      });
}

}  // namespace baton::python
