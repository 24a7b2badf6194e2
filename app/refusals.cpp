#include "app/refusals.hpp"

#include <utility>

namespace baton::app {
namespace {

constexpr int kStuck = 3;  ///< consecutive refusals after which the operator is told the ways out

}  // namespace

void Refusals::look(const Navigator& navigator) {
  const Refused* event = find_event<Refused>(navigator.events());
  const bool new_one = event != nullptr && !event->again;
  changed_ = changed_ || differs(navigator.command(), refused_);
  if (new_one) {
    ++count_;
    newest_ = *navigator.refusal();
  }
  if (navigator.motion() != nullptr) {
    times_ = 0;
    retrace_ = home_ = false;
  } else if (new_one) {
    const Command& command = navigator.refused();
    retrace_ = retrace_ || command.recall == Recall::retrace;
    home_ = home_ || command.recall == Recall::home;
    if (command.recall == Recall::none) {
      const bool same_part = std::exchange(part_, command.guide) == command.guide;
      if (!same_part || times_ == 0) times_ = 0, changed_ = true;
      if (std::exchange(changed_, false)) ++times_;  // a trembling hand repeats the same request
      refused_ = command;
    }
  }
  stuck_.reset();
  if (times_ >= kStuck) stuck_ = Stuck{part_, times_, navigator.history() > 0 && !retrace_, !home_};
}

}  // namespace baton::app
