#include "bench/velocity_tracking.hpp"

#include <algorithm>
#include <cmath>

#include "baton/guide/guide.hpp"
#include "baton/model/contact.hpp"

namespace baton::bench {
namespace {

constexpr double kSmoothing = 0.05;  ///< time constant of velocities [s]
constexpr double kApproach = 0.2;    ///< and of going to a place [s]
constexpr double kOnGround = 1e-4;   ///< [m]
constexpr double kClear = 5e-3;      ///< a careful foot goes sideways from this height on [m]

double tilt(const Mat3& R) {
  return std::acos(std::clamp(R(2, 2), -1.0, 1.0));
}

}  // namespace

VelocityTracking::VelocityTracking(const RobotModel& robot, const Posture& start, Care care)
    : robot_(&robot),
      care_(care),
      dt_(robot.profile().tick.period),
      T_(robot.profile().duration.first),
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
  velocity += std::min(1.0, dt_ / kSmoothing) * (wanted - velocity);
}

Vec3 VelocityTracking::towards(const Vec3& difference, double speed) {
  const Vec3 velocity = difference / kApproach;
  return velocity.norm() > speed ? Vec3(velocity.normalized() * speed) : velocity;
}

bool VelocityTracking::wants_up(Side side, const Command& command) const {
  if (command.guide != foot(side)) return false;
  const bool deflected = command.axes[0] != 0.0 || command.axes[1] != 0.0 || command.axes[5] != 0.0;
  return deflected || command.lift[side] >= Guide::kLeastLift;
}

void VelocityTracking::tick(const Command& raw) {
  const Command command = sanitised(raw);
  const Mat3 heading = rotation_z(mean_yaw(yaw_of(targets_.sole.left.R), yaw_of(targets_.sole.right.R)));
  if (rises_ && contact_[*rises_] && !wants_up(*rises_, command)) rises_.reset();
  for (const Side side : kSides) {
    if (!rises_ && wants_up(side, command)) rises_ = side;
  }
  for (const Side side : kSides)
    move_foot(side, command, heading);
  move_com(command, heading);
  move_trunk(command, heading);
  move_hands(command, heading);

  VecX q = q_;  // linearised where the joints would go by themselves, as the planner does
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
  const double throttle = command.lift[side] >= Guide::kLeastLift ? command.lift[side] * profile.swing.lift : 0.0;
  const double wanted = !up ? 0.0 : throttle > 0.0 ? throttle : profile.swing.clearance;
  const double climb = profile.swing.lift / (0.5 * T_);
  const bool moves = command.guide == foot(side) && (care_ == Care::none ? up : sole.p.z() > kClear);
  Vec3 velocity = Vec3::Zero();
  if (moves) velocity = heading * Vec3(command.axes[0], command.axes[1], 0.0) * profile.reach.foot / T_;
  velocity.z() = std::clamp((wanted - sole.p.z()) / (0.25 * kApproach), -climb, climb);
  smooth(foot_velocity_[side], velocity);
  yaw_rate_[side] += std::min(1.0, dt_ / kSmoothing) *
                     ((moves ? command.axes[5] * profile.reach.rotation / T_ : 0.0) - yaw_rate_[side]);
  if (contact_[side] && !up) {
    foot_velocity_[side].setZero();
    yaw_rate_[side] = 0.0;
    return;
  }
  sole.p += dt_ * foot_velocity_[side];
  sole.R = rotation_z(dt_ * yaw_rate_[side]) * sole.R;
  if (care_ == Care::regions) {
    const Profile::Region& region = profile.region;
    Vec3 at = stance.R.transpose() * (sole.p - stance.p);
    at.x() = std::clamp(at.x(), region.foot_x.lo, region.foot_x.hi);
    at.y() = sign_of(side) * std::clamp(sign_of(side) * at.y(), region.foot_lateral.lo, region.foot_lateral.hi);
    sole.p.head<2>() = (stance.p + stance.R * at).head<2>();
    const double turned = wrap_angle(yaw_of(sole.R) - yaw_of(stance.R));
    sole.R = rotation_z(yaw_of(stance.R) + std::clamp(turned, -region.foot_yaw, region.foot_yaw));
  }
  contact_[side] = !up && sole.p.z() < kOnGround;
  if (contact_[side]) sole.p.z() = 0.0;
  sole.p.z() = std::max(sole.p.z(), 0.0);
}

void VelocityTracking::move_com(const Command& command, const Mat3& heading) {
  const Profile& profile = robot_->profile();
  const double speed = profile.reach.trunk / T_;
  Vec3& com = targets_.com;
  if (command.guide == Part::trunk && !rises_) {
    smooth(com_velocity_, heading * command.axes.head<3>() * speed);
    com += dt_ * com_velocity_;
    if (care_ == Care::regions) {
      const ConvexPolygon support = support_polygon(*robot_, targets_.sole, contact_, com, 0.0);
      const ConvexPolygon region = support.inset(profile.margin.stand_on);
      if (region.margin(com.head<2>()) < 0.0) com.head<2>() = region.nearest(com.head<2>());
      com.z() = std::clamp(com.z(), profile.region.com_height.lo, profile.region.com_height.hi);
    }
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
  const Vec3 wanted = command.guide == Part::trunk ? Vec3(heading * command.axes.tail<3>() * speed)
                                                   : towards(rotation_error(heading, targets_.trunk), speed);
  smooth(trunk_rate_, wanted);
  const Mat3 next = rotation_exp(dt_ * trunk_rate_) * targets_.trunk;
  const Profile::Region& region = robot_->profile().region;
  const double turned = wrap_angle(yaw_of(next) - yaw_of(heading));
  const bool too_far = (tilt(next) > region.trunk_inclination && tilt(next) > tilt(targets_.trunk)) ||
                       std::abs(turned) > region.foot_yaw;
  if (care_ == Care::regions && too_far && command.guide == Part::trunk) {
    trunk_rate_.setZero();
  } else {
    targets_.trunk = next;
  }
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
    smooth(hand_velocity_[side], heading * command.axes.head<3>() * profile.reach.hand / T_);
    const Vec3 next = target->p + dt_ * hand_velocity_[side];
    if (care_ == Care::regions) {
      const Vec3 shoulder = ik_.kinematics().shoulder(side);
      const double most = profile.region.hand_distance;
      if ((next - shoulder).norm() > most && (next - shoulder).norm() > (target->p - shoulder).norm()) {
        hand_velocity_[side].setZero();
        continue;
      }
    }
    target->p = next;
  }
}

}  // namespace baton::bench
