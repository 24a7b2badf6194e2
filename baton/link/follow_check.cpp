#include "baton/link/follow_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace baton::link {

FollowCheck::FollowCheck(const RobotModel& robot, Parameters parameters) : robot_(&robot), parameters_(parameters) {
  const double ticks = std::max(1.0, std::round(parameters_.window / robot.profile().tick.period));
  ticks_.resize(static_cast<std::size_t>(ticks));
}

void FollowCheck::take(const VecX& commanded, const VecX& measured) {
  Tick& oldest = ticks_[taken_++ % ticks_.size()];
  const Tick then = std::exchange(oldest, {commanded, measured});
  if (taken_ <= ticks_.size()) return;
  const VecX told = commanded - then.commanded;
  const VecX went = measured - then.measured;
  const double moves = told.squaredNorm();
  // A joint angle that is not a number is the sensors' matter.
  const bool follows = moves < parameters_.moves * parameters_.moves || !(told.dot(went) < parameters_.share * moves);
  stuck_ = follows ? 0 : stuck_ + 1;
  if (stuck_ * robot_->profile().tick.period < parameters_.lasts) {
    why_.clear();
    return;
  }
  if (!why_.empty()) return;
  Eigen::Index j = 0;
  (told - went).cwiseAbs().maxCoeff(&j);
  why_ = fmt::format("{} was told to go by {:.3f} rad to {:.3f} rad, and went by {:.3f} rad to {:.3f} rad",
                     robot_->joints()[static_cast<std::size_t>(j)].name, told[j], commanded[j], went[j], measured[j]);
}

}  // namespace baton::link
