#include "bench/judge.hpp"

#include <algorithm>
#include <cmath>

namespace baton::bench {
namespace {

constexpr double kHeld = 0.02;      ///< [s]
constexpr double kPosition = 1e-3;  ///< of feet and COM [m]
constexpr double kRotation = 1e-2;  ///< of the feet [rad]
constexpr double kRounding = 1e-6;  ///< tolerance on a joint's range [rad] and speed [relative]

}  // namespace

Judge::Judge(const RobotModel& robot)
    : robot_(&robot),
      kinematics_(robot),
      dt_(robot.profile().tick.period),
      held_(std::max(1, static_cast<int>(std::lround(kHeld / dt_)))),
      dq_(robot.nv()),
      ddq_(robot.nv()),
      dq_next_(robot.nv()),
      force_(robot.nv()) {}

bool Judge::lasts(Cause cause, bool bad) {
  int& since = since_[static_cast<std::size_t>(cause)];
  since = bad ? since + 1 : 0;
  return since >= held_;
}

std::optional<Cause> Judge::see(const VecX& q, const BySide<Pose>& sole, const Vec3& com, const BySide<bool>& contact) {
  const std::optional<Seen> first = std::move(before_);
  before_ = std::move(last_);
  last_ = Seen{q, sole, com, contact};
  if (!first) return std::nullopt;
  const Seen& now = *before_;
  difference(*robot_, dq_, dt_, first->q, now.q);
  difference(*robot_, dq_next_, dt_, now.q, q);
  ddq_ = (dq_next_ - dq_) / dt_;
  dq_ = 0.5 * (dq_ + dq_next_);
  kinematics_.inverse_dynamics(now.q, dq_, ddq_, force_);

  double position = (kinematics_.com() - now.com).norm();
  double rotation = 0.0;
  BySide<Pose> soles;
  for (const Side side : kSides) {
    soles[side] = kinematics_.sole(side);
    position = std::max(position, (soles[side].p - now.sole[side].p).norm());
    rotation = std::max(rotation, rotation_error(now.sole[side].R, soles[side].R).norm());
  }
  const double plane = support_plane(soles, now.contact);
  const ConvexPolygon support = support_polygon(*robot_, soles, now.contact, kinematics_.com(), plane);
  const bool tips = !(support.margin(ground_wrench(kinematics_, force_).zmp(plane)) >= 0.0);

  bool joint = false;
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    const Joint& limits = robot_->joints()[j];
    const auto i = static_cast<Eigen::Index>(j);
    joint = joint || now.q[7 + i] < limits.position.lo - kRounding || now.q[7 + i] > limits.position.hi + kRounding ||
            std::abs(dq_[6 + i]) > limits.motor.no_load * (1.0 + kRounding);
  }
  if (ticks_++ % held_ == 0) {  // as expensive as all other checks
    constexpr double kNear = 1e-3;
    collides_ =
        kinematics_.self_distance(kNear) < 0.0 || separation(sole_outline(*robot_, Side::left, soles.left),
                                                             sole_outline(*robot_, Side::right, soles.right)) < 0.0;
  }

  std::optional<Cause> cause;
  const auto check = [&](Cause what, bool bad) {
    if (lasts(what, bad) && !cause) cause = what;
  };
  check(Cause::joint, joint);
  check(Cause::collision, collides_);
  check(Cause::following, !(position <= kPosition) || !(rotation <= kRotation));
  check(Cause::zmp, tips);
  return cause;
}

}  // namespace baton::bench
