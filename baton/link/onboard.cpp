#include "baton/link/onboard.hpp"

#include <utility>

#include "baton/link/engage.hpp"
#include "baton/model/error.hpp"

namespace baton::link {

Onboard::Onboard(const RobotModel& model, const World& world, Robot& robot, Parameters parameters)
    : model_(&model),
      parameters_(std::move(parameters)),
      session_(model, world, robot, engage(model, world.site("start"), robot.read().q),
               {.modes = parameters_.navigation.modes,
                .source = parameters_.navigation.source,
                .planning = parameters_.planning.get(),
                .hangs = parameters_.navigation.hangs}) {
  session_.add(*this);
}

const Tick& Onboard::step(double battery) {
  const bool was_stale = tick_.stale;
  tick_.stale = held_ || (stick_ && !parameters_.lock_step && age(*stick_) > kFresh);
  tick_.command = stick_ && !tick_.stale ? stick_->command : Command{};
  if (tick_.stale && !was_stale) session_.drive_arms(released_arms(*model_));
  tick_.planning.clear();
  session_.step(tick_.command);
  tick_.reading.battery = battery;
  tick_.reading.sequence = ticks_++;
  return tick_;
}

void Onboard::drive_arms(const ArmTargets& targets) {
  if (held_) throw InputError("something is wrong with the robot, so nothing drives the arms");
  if (tick_.stale) throw InputError("the stick's positions are too old, so nothing drives the arms");
  session_.drive_arms(targets);
}

void Onboard::lose(double time) {
  lost_ = stick_ && stick_->seen > lost_at_ ? time : lost_ + time;
  lost_at_ = ticks_;
}

double Onboard::age(const StickPosition& stick) const {
  return static_cast<double>(ticks_ - stick.seen) * model_->profile().tick.period +
         (stick.seen <= lost_at_ ? lost_ : 0.0);
}

void Onboard::driver_gone() {
  stick_.reset();
  session_.drive_arms(released_arms(*model_));
}

bool Onboard::rests() const {
  const BySide<bool>& contact = session_.navigator().sample().contact;
  return session_.resting() && contact.left && contact.right;
}

void Onboard::on_tick(const TickRecord& record) {
  tick_.reading.measurement = record.measurement;
  tick_.target = commanded(record.target);
}

}  // namespace baton::link
