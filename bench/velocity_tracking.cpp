#include "bench/velocity_tracking.hpp"

#include <algorithm>
#include <cmath>

#include "baton/guide/guide.hpp"
#include "baton/model/contact.hpp"

namespace baton::bench {
namespace {

constexpr double kApproach = 0.2;   ///< time constant of approaching a target, and of stopping before a limit [s]
constexpr double kOnGround = 1e-4;  ///< [m]
constexpr double kClear = 5e-3;     ///< height above which a careful foot moves sideways [m]

}  // namespace

VelocityTracking::VelocityTracking(const RobotModel& robot, const Posture& start, Care care)
    : robot_(&robot),
      care_(care),
      dt_(robot.profile().tick.period),
      T_(robot.profile().duration.first),
      share_(1.0 - std::exp(-robot.omega() * dt_)),
      ik_(robot),
      height_(start.com.z()),
      q_(start.q),
      before_(start.q) {
  targets_.com = start.com;
  targets_.trunk = start.trunk;
  targets_.sole = start.sole;
  targets_.arms = start.q.tail(robot.nv() - 6);
}

void VelocityTracking::smooth(Vec3& velocity, const Vec3& wanted) const {
  velocity += share_ * (wanted - velocity);
}

Vec3 VelocityTracking::towards(const Vec3& difference, double speed) {
  const Vec3 velocity = difference / kApproach;
  return velocity.norm() > speed ? Vec3(velocity.normalized() * speed) : velocity;
}

bool VelocityTracking::wants_up(Side side, const Command& command) const {
  if (command.guide != foot(side)) return false;
  const bool deflected = command.axes[0] != 0.0 || command.axes[1] != 0.0 || command.axes[5] != 0.0;
  return deflected || command.lift[side] >= kLeastLift;
}

void VelocityTracking::tick(const Command& raw) {
  const Command command = sanitised(raw);
  const Mat3 heading = rotation_z(mean_yaw(targets_.sole));
  if (rises_ && contact_[*rises_] && !wants_up(*rises_, command)) rises_.reset();
  for (const Side side : kSides) {
    if (!rises_ && wants_up(side, command)) rises_ = side;
  }
  for (const Side side : kSides)
    move_foot(side, command, heading);
  move_com(command, heading);
  move_trunk(command, heading);
  move_hands(command, heading);

  VecX q = q_;  // linearised at the extrapolated joint angles, as in the planner
  q.tail(robot_->nv() - 6) += (q_ - before_).tail(robot_->nv() - 6);
  q.head<3>() += (q_ - before_).head<3>();
  before_ = q_;
  (void)ik_.solve(targets_, before_, dt_, q, 3);
  q_ = q;
}

void VelocityTracking::move_foot(Side side, const Command& command, const Mat3& heading) {
  const Profile& profile = robot_->profile();
  Pose& sole = targets_.sole[side];
  const Pose& stance = targets_.sole[other(side)];
  bool up = rises_ == side && wants_up(side, command);
  if (up && contact_[side] && care_ == Care::regions) {
    const ConvexPolygon support = sole_outline(*robot_, other(side), stance);
    up = support.margin(targets_.com.head<2>()) >= profile.margin.stand_on;
  }
  const double throttle = command.lift[side] >= kLeastLift ? command.lift[side] * profile.swing.lift : 0.0;
  const double wanted = !up ? 0.0 : throttle > 0.0 ? throttle : profile.swing.clearance;
  const double climb = profile.swing.lift / (0.5 * T_);
  const bool moves = command.guide == foot(side) && (care_ == Care::none ? up : sole.p.z() > kClear);
  Vec3 velocity = Vec3::Zero();
  double rate = 0.0;
  if (moves) {
    velocity = heading * Vec3(command.axes[0], command.axes[1], 0.0) * profile.reach.foot / T_;
    rate = command.axes[5] * profile.reach.rotation / T_;
    if (care_ == Care::regions) {
      const Profile::Region& region = profile.region;
      Pose next{sole.p + kApproach * velocity, rotation_z(kApproach * rate) * sole.R};
      Vec3 at = stance.R.transpose() * (next.p - stance.p);
      at.x() = std::clamp(at.x(), region.foot_x.lo, region.foot_x.hi);
      at.y() = sign_of(side) * std::clamp(sign_of(side) * at.y(), region.foot_lateral.lo, region.foot_lateral.hi);
      next.p.head<2>() = (stance.p + stance.R * at).head<2>();
      const double turned = wrap_angle(yaw_of(next.R) - yaw_of(stance.R));
      next.R = rotation_z(yaw_of(stance.R) + std::clamp(turned, -region.foot_yaw, region.foot_yaw));
      const ConvexPolygon beside = sole_outline(*robot_, other(side), stance);
      const double gap = separation(sole_outline(*robot_, side, next), beside);
      const bool closer = gap < region.sole_gap && gap < separation(sole_outline(*robot_, side, sole), beside);
      velocity = closer ? Vec3(Vec3::Zero()) : Vec3((next.p - sole.p) / kApproach);
      rate = closer ? 0.0 : wrap_angle(yaw_of(next.R) - yaw_of(sole.R)) / kApproach;
    }
  }
  velocity.z() = std::clamp((wanted - sole.p.z()) / (0.25 * kApproach), -climb, climb);
  if (contact_[side] && !up) {
    foot_velocity_[side].setZero();
    yaw_rate_[side] = 0.0;
    return;
  }
  smooth(foot_velocity_[side], velocity);
  foot_velocity_[side].z() = velocity.z();
  yaw_rate_[side] += share_ * (rate - yaw_rate_[side]);
  sole.p += dt_ * foot_velocity_[side];
  sole.R = rotation_z(dt_ * yaw_rate_[side]) * sole.R;
  contact_[side] = !up && sole.p.z() < kOnGround;
  if (contact_[side]) sole.p.z() = 0.0;
  sole.p.z() = std::max(sole.p.z(), 0.0);
}

void VelocityTracking::move_com(const Command& command, const Mat3& heading) {
  const Profile& profile = robot_->profile();
  const double speed = profile.reach.trunk / T_;
  Vec3& com = targets_.com;
  if (command.guide == Part::trunk && !rises_) {
    Vec3 velocity = heading * command.axes.head<3>() * speed;
    if (care_ == Care::regions) {
      const Range& heights = profile.region.com_height;
      Vec3 next = com + kApproach * velocity;
      const ConvexPolygon support = support_polygon(*robot_, targets_.sole, contact_, com, 0.0);
      const ConvexPolygon region = support.inset(profile.margin.stand_on);
      if (region.margin(next.head<2>()) < 0.0) next.head<2>() = region.nearest(next.head<2>());
      next.z() = std::clamp(next.z(), heights.lo, heights.hi);
      velocity = (next - com) / kApproach;
    }
    smooth(com_velocity_, velocity);
    com += dt_ * com_velocity_;
    height_ = com.z();
    return;
  }
  Vec3 place = rises_ ? targets_.sole[other(*rises_)].p : Vec3(0.5 * (targets_.sole.left.p + targets_.sole.right.p));
  place.z() = height_;
  smooth(com_velocity_, towards(place - com, speed));
  com += dt_ * com_velocity_;
}

void VelocityTracking::move_trunk(const Command& command, const Mat3& heading) {
  const double speed = robot_->profile().reach.rotation / T_;
  Vec3 rate = towards(rotation_error(heading, targets_.trunk), speed);
  if (command.guide == Part::trunk) {
    rate = heading * command.axes.tail<3>() * speed;
    const Profile::Region& region = robot_->profile().region;
    const Mat3 next = rotation_exp(kApproach * rate) * targets_.trunk;
    const bool too_far = (tilt_of(next) > region.trunk_inclination && tilt_of(next) > tilt_of(targets_.trunk)) ||
                         std::abs(wrap_angle(yaw_of(next) - yaw_of(heading))) > region.foot_yaw;
    if (care_ == Care::regions && too_far) rate.setZero();
  }
  smooth(trunk_rate_, rate);
  targets_.trunk = rotation_exp(dt_ * trunk_rate_) * targets_.trunk;
}

void VelocityTracking::move_hands(const Command& command, const Mat3& heading) {
  const Profile& profile = robot_->profile();
  for (const Side side : kSides) {
    std::optional<Pose>& target = targets_.hand[side];
    if (command.guide != hand(side)) {
      if (!target) continue;
      target.reset();
      hand_velocity_[side].setZero();
      for (const int j : robot_->arm(side))
        targets_.arms[j] = q_[7 + j];
      continue;
    }
    if (!target) {
      Kinematics kinematics(*robot_);
      kinematics.set(q_);
      target = kinematics.hand(side);
    }
    Vec3 velocity = heading * command.axes.head<3>() * profile.reach.hand / T_;
    if (care_ == Care::regions) {
      const Vec3 arm = target->p - ik_.kinematics().shoulder(side);
      const double next = (arm + kApproach * velocity).norm();
      if (next > profile.region.hand_distance && next > arm.norm()) velocity.setZero();
    }
    smooth(hand_velocity_[side], velocity);
    target->p += dt_ * hand_velocity_[side];
  }
}

}  // namespace baton::bench
