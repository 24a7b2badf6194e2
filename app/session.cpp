#include "app/session.hpp"

#include <ctime>

#include "baton/ik/stand.hpp"
#include "baton/robot/ideal_robot.hpp"

namespace baton::app {

Modes modes_of(const std::string& duration, const std::string& on_limit) {
  return {duration == "search" ? DurationRule::search : DurationRule::paper,
          on_limit == "discard" ? OnLimit::discard : OnLimit::shrink};
}

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

Session::Session(const RobotModel& robot, const World& world, On on, std::optional<Posture> start,
                 SimulatedRobot::Parameters parameters, Modes modes)
    : robot_(&robot),
      world_(&world),
      start_(start ? *start : stand(robot, world.site("start"), robot.profile().stance.com_height)),
      navigator_(robot, start_),
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
  if (on_tick) on_tick({t_, navigator_, body_->truth(), target, tick_us});
  body_->write(target);
  if (const std::optional<Problem> problem = navigator_.request()) {
    const double asked = cpu_us();
    PlanningResult result = planning_.plan(*problem);
    if (on_plan) on_plan({t_, *problem, result, cpu_us() - asked});
    navigator_.offer(std::move(result));
  }
  t_ = static_cast<double>(++ticks_) * robot_->profile().tick.period;
}

}  // namespace baton::app
