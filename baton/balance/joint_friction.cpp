#include "baton/balance/joint_friction.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kTime = 2.0;   ///< time constant, while every joint of the legs moves [1/ω]
constexpr double kSlow = 0.02;  ///< speed below which a joint may be about to turn back [ω]

}  // namespace

JointFriction::JointFriction(const RobotModel& robot)
    : robot_(&robot),
      follows_(robot.omega() * robot.profile().tick.period / kTime),
      most_(1.0 - robot.profile().margin.torque) {}

double JointFriction::direction(double speed) const {
  return std::tanh(speed / (kSlow * robot_->omega()));
}

void JointFriction::update(const Eigen::Ref<const VecX>& speed, const Eigen::Ref<const VecX>& error) {
  // Normalised least mean squares. What the servo adds to the torque that it was told beforehand follows the direction
  // as long as friction is not compensated. In the arms it is the same friction, but they hardly move.
  double missing = 0.0;
  double moving = 0.0;
  for (const Side side : kSides) {
    for (const int j : robot_->leg(side)) {
      const Joint& joint = robot_->joints()[static_cast<std::size_t>(j)];
      const double way = direction(speed[j]);
      missing += joint.gains.kp * error[j] / joint.motor.stall * way;
      moving += way * way;
    }
  }
  share_ = std::clamp(share_ + follows_ * missing / std::max(moving, 1.0), 0.0, most_);
}

double JointFriction::torque(int joint, double speed) const {
  return share_ * robot_->joints()[static_cast<std::size_t>(joint)].motor.stall * direction(speed);
}

}  // namespace baton
