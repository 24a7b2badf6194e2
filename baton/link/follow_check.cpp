#include "baton/link/follow_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace baton::link {
namespace {

// A robot with long ticks is some of them behind.
constexpr long kWindow = 8;  ///< least length of the window [ticks]
constexpr int kLasts = 12;   ///< least time for which it must not have followed [ticks]

}  // namespace

FollowCheck::FollowCheck(const RobotModel& robot, Parameters parameters)
    : robot_(&robot),
      parameters_(parameters),
      lasts_(std::max(kLasts, static_cast<int>(std::lround(parameters.lasts / robot.profile().tick.period)))) {
  const long ticks = std::max(kWindow, std::lround(parameters_.window / robot.profile().tick.period));
  ticks_.resize(static_cast<std::size_t>(ticks));
  for (const Side side : kSides)
    joints_.insert(joints_.end(), robot.leg(side).begin(), robot.leg(side).end());
}

void FollowCheck::begin() {
  taken_ = 0;
  stuck_ = 0;
  why_.clear();
}

VecX FollowCheck::of_legs(const VecX& q) const {
  VecX some(static_cast<Eigen::Index>(joints_.size()));
  for (std::size_t i = 0; i < joints_.size(); ++i)
    some[static_cast<Eigen::Index>(i)] = q[joints_[i]];
  return some;
}

void FollowCheck::take(const VecX& commanded, const VecX& measured) {
  Tick& oldest = ticks_[taken_++ % ticks_.size()];
  const Tick now{of_legs(commanded), of_legs(measured)};
  const Tick then = std::exchange(oldest, now);
  if (taken_ <= ticks_.size()) return;
  const VecX told = now.commanded - then.commanded;
  const VecX went = now.measured - then.measured;
  const double moves = told.squaredNorm();
  // A joint angle that is not a number is the sensors' matter.
  const bool follows = moves < parameters_.moves * parameters_.moves || !(told.dot(went) < parameters_.share * moves);
  stuck_ = follows ? 0 : stuck_ + 1;
  if (stuck_ < lasts_) {
    why_.clear();
    return;
  }
  if (!why_.empty()) return;
  Eigen::Index j = 0;
  (told - went).cwiseAbs().maxCoeff(&j);
  why_ = fmt::format("{} was told to go by {:.3f} rad to {:.3f} rad, and went by {:.3f} rad to {:.3f} rad",
                     robot_->joints()[static_cast<std::size_t>(joints_[static_cast<std::size_t>(j)])].name, told[j],
                     now.commanded[j], went[j], now.measured[j]);
}

}  // namespace baton::link
