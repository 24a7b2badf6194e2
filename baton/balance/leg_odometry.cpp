#include "baton/balance/leg_odometry.hpp"

#include <algorithm>
#include <utility>

namespace baton {
namespace {

// Rates are the same for any size of robot.
constexpr double kTrust = 20.0;  ///< rate at which the velocity follows the soles that stand [1/s]
constexpr double kRelax = 10.0;  ///< rate at which a foothold follows where a sole with no load is [1/s]

}  // namespace

LegOdometry::LegOdometry(const RobotModel& robot, const Vec3& root, const BySide<Vec3>& sole)
    : robot_(&robot),
      period_(robot.profile().tick.period),
      jacobian_(3, robot.nv()),
      place_(root),
      foothold_(sole),
      footfall_(sole) {}

void LegOdometry::update(const Kinematics& kinematics, const VecX& dq, const Vec3& acceleration,
                         const SoleContact& contact) {
  const bool first = std::exchange(first_, false);
  const BySide<bool>& touch = contact.touch();
  const double total = contact.total();
  const auto share = [&](Side side) { return touch[side] ? contact.load()[side] / total : 0.0; };
  // Where the soles that stand say that the root is, and how fast it moves.
  BySide<Vec3> from_root, moves;
  for (const Side side : kSides) {
    from_root[side] = kinematics.sole(side).p;
    kinematics.point_jacobian(robot_->foot_body(side), from_root[side], jacobian_);
    moves[side].noalias() = jacobian_ * dq;
  }
  velocity_ += period_ * acceleration;
  if (total > 0.0) {
    Vec3 place = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    for (const Side side : kSides) {
      place += share(side) * (foothold_[side] - from_root[side]);
      velocity -= share(side) * moves[side];
    }
    place_ = place;
    velocity_ += first ? Vec3(velocity - velocity_) : Vec3(period_ * kTrust * (velocity - velocity_));
  } else {
    place_ += period_ * velocity_;
  }
  for (const Side side : kSides) {
    const double follows = touch[side] ? (1.0 - share(side)) * std::min(1.0, period_ * kRelax) : 1.0;
    foothold_[side] += follows * (place_ + from_root[side] - foothold_[side]);
    if (!touch[side]) continue;
    if (!touched_[side]) gone_ += (foothold_[side] - footfall_[side]).head<2>().norm();
    footfall_[side] = foothold_[side];
  }
  touched_ = touch;
}

void LegOdometry::shift(const Vec3& by) {
  place_ += by;
  for (const Side side : kSides)
    foothold_[side] += by;
}

}  // namespace baton
