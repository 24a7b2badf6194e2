#include "baton/run/session.hpp"

#include <fmt/format.h>

#include <utility>

#include "baton/model/error.hpp"
#include "baton/run/cpu_time.hpp"

namespace baton {
namespace {

/// Counts a tick when it is over, by an exception too: the navigator has lived through it then.
class CountTick {
 public:
  explicit CountTick(long& ticks) : ticks_(&ticks) {}
  CountTick(const CountTick&) = delete;
  CountTick& operator=(const CountTick&) = delete;
  ~CountTick() { ++*ticks_; }

 private:
  long* ticks_;
};

/// @throws InputError another length
void check_length(const char* what, Eigen::Index length, const RobotModel& model) {
  const int joints = model.nv() - 6;
  if (length == joints) return;
  throw InputError(fmt::format("the reading of robot {} has {} {}; must be {}, one for each joint of its model",
                               model.profile().name, length, what, joints));
}

}  // namespace

Session::Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start,
                 const Parameters& parameters)
    : model_(&model),
      world_(&world),
      robot_(&robot),
      start_(start),
      gait_(parameters.modes.gait),
      source_(parameters.source),
      hangs_(parameters.hangs),
      planning_(parameters.planning) {
  if (planning_ == nullptr) planning_ = &on_the_spot_.emplace(model, world, parameters.modes);
  begin();
}

void Session::begin() {
  navigator_.emplace(*model_, *world_, start_, gait_, source_);
  if (hangs_) navigator_->hang();
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
  check_length("joint angles (q)", measurement.q.size(), *model_);
  check_length("joint speeds (dq)", measurement.dq.size(), *model_);
  if (measurement.torque.size() != 0) check_length("motor torques (torque)", measurement.torque.size(), *model_);
  const CountTick count(ticks_);
  const double before = cpu_us();
  const JointTarget& target = navigator_->tick(measurement, command);
  const TickRecord record{t(), *navigator_, measurement, truth(), target, cpu_us() - before};
  for (Sink* sink : sinks_)
    sink->on_tick(record);
  robot_->write(target);
  plan();
}

void Session::drive_arms(const ArmTargets& targets) {
  navigator_->drive_arms(targets);
  for (Sink* sink : sinks_)
    sink->on_arms(targets);
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
