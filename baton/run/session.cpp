#include "baton/run/session.hpp"

#include <cmath>
#include <ctime>
#include <utility>

#include "baton/ik/stand.hpp"
#include "baton/robot/ideal_robot.hpp"

namespace baton {

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
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
    navigator_.offer(std::move(answer->result));
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

}  // namespace baton
