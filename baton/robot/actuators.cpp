#include "baton/robot/actuators.hpp"

namespace baton {
namespace {

constexpr double kRounding = 1e-9;  ///< tolerance for accumulated time steps [s]

}  // namespace

Actuators::Actuators(const RobotModel& robot, const ActuatorErrors& errors, double period)
    : robot_(&robot), errors_(errors), period_(period), joints_(robot.joints()) {
  for (Joint& joint : joints_) {
    joint.gains.kp *= errors.kp;
    joint.motor.stall *= errors.strength;
  }
}

void Actuators::send(const JointTarget& target, double now) {
  sent_.push_back({now + errors_.delay, target});
}

void Actuators::advance(double now) {
  while (sent_.size() > 1 && sent_[1].arrives <= now + kRounding)
    sent_.pop_front();
  to_end_ = sent_.front().arrives + period_ - now;
}

double Actuators::torque(std::size_t joint, double q, double dq) const {
  const Joint& own = joints_[joint];
  const ServoCommand command = servo_command(*robot_, joint, sent_.front().target, to_end_);
  return motor_torque(own.motor, errors_.gain * servo_torque(own.gains, command, q, dq));
}

}  // namespace baton
