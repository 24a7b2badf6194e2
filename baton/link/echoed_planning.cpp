#include "baton/link/echoed_planning.hpp"

#include <thread>
#include <utility>

namespace baton::link {
namespace {

constexpr std::chrono::microseconds kGlance{100};

}  // namespace

void EchoedPlanning::post(Request request) {
  planner_->post(std::move(request));
  ++next_;
}

std::optional<Planning::Reply> EchoedPlanning::poll(long tick) {
  if (tick != tick_) {
    if (next_ < events_.size()) throw LinkError("the robot plans something else than is planned here");
    tick_ = tick;
    events_ = robot_->tick().planning;
    next_ = 0;
  }
  if (!next_is(PlanningEvent::answer)) return std::nullopt;
  if (planner_->idle()) throw LinkError("the robot has an answer to what was not asked here");
  ++next_;
  while (true) {
    if (std::optional<Reply> reply = planner_->poll(tick)) return reply;
    std::this_thread::sleep_for(kGlance);
  }
}

void EchoedPlanning::reset() {
  planner_->reset();
  tick_ = -1;
  events_.clear();
  next_ = 0;
}

}  // namespace baton::link
