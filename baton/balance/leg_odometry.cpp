#include "baton/balance/leg_odometry.hpp"

#include <algorithm>
#include <utility>

namespace baton {
namespace {

constexpr double kVelocityRate = 1.5;      ///< at which the velocity follows that of the soles in contact [ω]
constexpr double kUsualOff = 0.03;         ///< beyond this it follows more slowly [COM height × ω]
constexpr double kUnusual = 0.3;           ///< share of that rate there
constexpr double kWrong = 0.06;            ///< beyond this the IMU may be wrong: it follows as fast [COM height × ω]
constexpr double kMoves = 0.03;            ///< speed from which a sole in contact is taken to move [COM height × ω]
constexpr double kFootholdRate = 1.6;      ///< at which the foothold of a sole with little load follows the sole [ω]
constexpr double kLightHeightRate = 16.0;  ///< added for its height, with no load at all: it may not stand yet [ω]
constexpr double kLight = 0.15;            ///< load below which some of that is added, share of the weight
constexpr double kFlies = 3.0;             ///< longest time in the air of a robot that nobody holds [1/ω]
constexpr double kPivots = 0.4;            ///< load below which a tilting sole pivots about its pressure [weight]

}  // namespace

LegOdometry::LegOdometry(const RobotModel& robot, const Vec3& root, const BySide<Vec3>& sole)
    : robot_(&robot),
      period_(robot.profile().tick.period),
      jacobian_(3, robot.nv()),
      place_(root),
      foothold_(sole),
      footfall_(sole) {}

void LegOdometry::update(const Kinematics& kinematics, const VecX& dq, const Vec3& acceleration,
                         const SoleContact& contact, const BySide<Wrench>& wrench) {
  const bool first = std::exchange(first_, false);
  const BySide<bool>& touch = contact.touch();
  const double total = contact.total();
  const auto share = [&](Side side) { return touch[side] ? contact.load()[side] / total : 0.0; };
  // Position and velocity of the root by the soles in contact.
  BySide<Vec3> from_root, velocity_from_root;
  for (const Side side : kSides) {
    from_root[side] = kinematics.sole(side).p;
    const Mat3& R = kinematics.sole(side).R;
    const Vec3 centre = pivot(side, wrench[side]);
    if (touch[side] && touched_before_[side] && !first) foothold_[side] += (sole_[side] - R) * centre;
    sole_[side] = R;
    kinematics.point_jacobian(robot_->foot_body(side), from_root[side] + R * centre, jacobian_);
    velocity_from_root[side].noalias() = jacobian_ * dq;
  }
  velocity_ += period_ * acceleration;
  if (total > 0.0) {
    Vec3 place = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    for (const Side side : kSides) {
      place += share(side) * (foothold_[side] - from_root[side]);
      velocity -= share(side) * velocity_from_root[side];
    }
    place_ = place;
    const double unit = robot_->omega() * robot_->profile().stance.com_height;
    const Vec3 off = velocity - velocity_;
    const Vec3 follows = bounded(off, kUsualOff * unit) + kUnusual * beyond(off, kUsualOff * unit) +
                         (1.0 - kUnusual) * beyond(off, kWrong * unit);
    velocity_ += first ? off : Vec3(period_ * kVelocityRate * robot_->omega() * follows);
    // Faster than the velocity is usually wrong: the sole slides, or a motor crosses its play, and the root does not
    // move. Much faster than that moves what is estimated by an accelerometer that is wrong, not the sole.
    for (const Side side : kSides) {
      if (share(side) < kPivots || !touched_before_[side] || first) continue;
      const Vec3 moves = beyond(Vec3(velocity_ + velocity_from_root[side]), kMoves * unit);
      if (moves.norm() <= kWrong * unit) foothold_[side].head<2>() += period_ * moves.head<2>();
    }
  } else if (contact.airborne() * robot_->omega() < kFlies) {
    place_ += period_ * velocity_;
  } else {
    velocity_.setZero();  // somebody holds it: errors of the accelerometer would carry it off by metres
  }
  for (const Side side : kSides) {
    const Vec3 sole = place_ + from_root[side];
    if (!touch[side]) {
      foothold_[side] = sole;
      continue;
    }
    const double step = (1.0 - share(side)) * period_ * robot_->omega();
    const double light = std::max(0.0, 1.0 - share(side) / kLight);
    const Vec3 follows(kFootholdRate, kFootholdRate, kFootholdRate + light * kLightHeightRate);
    foothold_[side] += (step * follows).cwiseMin(1.0).cwiseProduct(sole - foothold_[side]);
    if (!touched_before_[side]) walked_ += (foothold_[side] - footfall_[side]).head<2>().norm();
    footfall_[side] = foothold_[side];
  }
  touched_before_ = touch;
}

Vec3 LegOdometry::pivot(Side side, const Wrench& wrench) const {
  const double load = wrench.force.z();
  if (!(load > 0.0 && load < kPivots * robot_->mass() * kGravity)) return Vec3::Zero();
  const Vec2 centre = robot_->sole(side).nearest(wrench.zmp(0.0));
  return {centre.x(), centre.y(), 0.0};
}

void LegOdometry::shift(const Vec3& by) {
  place_ += by;
  for (const Side side : kSides)
    foothold_[side] += by;
}

}  // namespace baton
