#include "app/session.hpp"

#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <utility>

#include "app/scenario.hpp"
#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/robot/ideal_robot.hpp"

namespace baton::app {

Modes modes_of(const ModeOptions& o) {
  return {o.duration == "search" ? DurationRule::search : DurationRule::paper,
          o.on_limit == "discard" ? OnLimit::discard : OnLimit::shrink, o.gait == "flow" ? Gait::flow : Gait::stop};
}

RobotModel load_robot(const std::string& name_or_file, const std::optional<std::string>& drive) {
  RobotModel robot = RobotModel::load(name_or_file);
  return drive ? with_drive(robot, drive_named(*drive, "--drive")) : std::move(robot);
}

RobotModel robot_in(const PhysicsOptions& options, const std::string& name_or_file) {
  RobotModel robot = load_robot(name_or_file, options.drive);
  if (!options.scenario) return robot;
  const Drive drive = drive_of(scenario_named(*options.scenario), robot);
  return drive == robot.profile().drive ? std::move(robot) : with_drive(robot, drive);
}

SimulatedRobot::Parameters parameters_of(const PhysicsOptions& options, const RobotModel& robot, const std::string& on,
                                         long seed) {
  if (options.scenario && on != "sim")
    throw InputError(
        fmt::format("--scenario {} with --on {}: must be --on sim, there is physics", *options.scenario, on));
  if (!options.scenario && options.times != 1.0)
    throw InputError(fmt::format("--times {} without --scenario: there is nothing to be farther from", options.times));
  SimulatedRobot::Parameters parameters;
  if (options.scenario) {
    parameters.plant =
        plant_of(scenario_named(*options.scenario), robot, static_cast<std::uint64_t>(seed), options.times);
  }
  return parameters;
}

AnswerFaults faults_of(const AnswerOptions& options, std::uint64_t seed) {
  return {1e-3 * options.delay_ms, options.loss, seed};
}

RobotModel with_drive(const RobotModel& robot, Drive drive) {
  Profile profile = robot.profile();
  if (drive == Drive::stiff && profile.drive != Drive::stiff) {
    for (auto& [name, gains] : profile.gains)
      gains.kp *= kStiff;
  }
  profile.drive = drive;
  return RobotModel(std::move(profile));
}

StateSource state_named(const std::string& name) {
  for (const StateSource source : {StateSource::sensors, StateSource::torques, StateSource::perfect}) {
    if (name == to_string(source)) return source;
  }
  throw InputError(fmt::format("--state {}: should be sensors, torques or perfect", name));
}

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Session::Session(const RobotModel& robot, const World& world, On on, std::optional<Posture> start,
                 SimulatedRobot::Parameters parameters, Modes modes, StateSource state)
    : robot_(&robot),
      world_(&world),
      start_(start ? *start : stand(robot, world.site("start"), robot.profile().stance.com_height)),
      navigator_(robot, world, start_, modes.gait, state),
      modes_(modes),
      planning_(robot, world, modes) {
  const double period = robot.profile().tick.period;
  if (on == On::sim) {
    auto simulated = std::make_unique<SimulatedRobot>(robot, world, start_, period, parameters);
    simulated_ = simulated.get();
    model_text_ = simulated->model_text();
    body_ = std::move(simulated);
  } else {
    model_text_ = world.compose(robot, parameters.timestep);
    body_ = std::make_unique<IdealRobot>(robot, start_, period);
  }
}

void Session::step(const Command& command) {
  const Measurement measurement = body_->read();
  if (fallen()) navigator_.fall();
  const double before = cpu_us();
  const JointTarget& target = navigator_.tick(measurement, command);
  const double tick_us = cpu_us() - before;
  if (on_tick) on_tick({t_, navigator_, measurement, body_->truth(), target, tick_us});
  body_->write(target);
  plan();
  t_ = static_cast<double>(++ticks_) * robot_->profile().tick.period;
}

void Session::plan_on_a_thread() {
  thread_.emplace(*robot_, *world_, modes_);
}

void Session::spoil_answers(const AnswerFaults& faults) {
  faults_ = faults;
  dice_ = Dice(mixed_seed(faults.seed, 79));
}

void Session::plan() {
  navigator_.poll();
  const auto hand_in = [this] {
    std::optional<PlanningThread::Reply> answer = this->answer();
    if (!answer || lost_) return;
    if (on_plan) on_plan({t_, answer->request, answer->result, answer->plan_us});
    if (on_event) on_event(PlanningEvent::offer);
    navigator_.answer(std::move(answer->result));
  };
  hand_in();
  const bool busy = thread_ ? !thread_->idle() : ready_.has_value();
  if (busy) return;
  std::optional<Request> request = navigator_.request();
  if (!request) return;
  if (on_event) on_event(PlanningEvent::ask);
  post(*std::move(request));
  if (!thread_) hand_in();
}

std::optional<PlanningThread::Reply> Session::answer() {
  if (ticks_ < due_at_) return std::nullopt;
  return thread_ ? thread_->poll() : std::exchange(ready_, std::nullopt);
}

void Session::post(Request request) {
  const auto latest = static_cast<int>(std::lround(faults_.delay / robot_->profile().tick.period));
  due_at_ = ticks_ + dice_.between(0, latest);
  lost_ = dice_.share() < faults_.loss;
  if (thread_) return thread_->post(std::move(request));
  const double asked = cpu_us();
  Answer result = planning_.plan(request);
  ready_ = {std::move(request), std::move(result), cpu_us() - asked};
}

}  // namespace baton::app
