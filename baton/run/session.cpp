#include "baton/run/session.hpp"

#include <utility>

#include "baton/run/cpu_time.hpp"

namespace baton {

Session::Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start,
                 const Parameters& parameters)
    : model_(&model),
      world_(&world),
      robot_(&robot),
      start_(start),
      gait_(parameters.modes.gait),
      source_(parameters.source),
      planning_(parameters.planning) {
  if (planning_ == nullptr) planning_ = &on_the_spot_.emplace(model, world, parameters.modes);
  begin();
}

void Session::begin() {
  navigator_.emplace(*model_, *world_, start_, gait_, source_);
  ticks_ = 0;
}

void Session::reset() {
  robot_->reset();
  planning_->reset();
  sinks_.clear();
  begin();
}

void Session::step(const Command& command) {
  const Measurement measurement = robot_->read();
  const double before = cpu_us();
  const JointTarget& target = navigator_->tick(measurement, command);
  const TickRecord record{t(), *navigator_, measurement, truth(), target, cpu_us() - before};
  for (Sink* sink : sinks_)
    sink->on_tick(record);
  robot_->write(target);
  plan();
  ++ticks_;
}

void Session::plan() {
  navigator_->poll();
  hand_in();
  if (!planning_->idle()) return;
  std::optional<Request> request = navigator_->request();
  if (!request) return;
  for (Sink* sink : sinks_)
    sink->on_planning(PlanningEvent::ask);
  planning_->post(*std::move(request));
  hand_in();
}

void Session::hand_in() {
  std::optional<Planning::Reply> reply = planning_->poll(ticks_);
  if (!reply) return;
  for (Sink* sink : sinks_)
    sink->on_plan({t(), reply->request, reply->answer, reply->plan_us});
  for (Sink* sink : sinks_)
    sink->on_planning(PlanningEvent::answer);
  navigator_->answer(std::move(reply->answer));
}

}  // namespace baton
