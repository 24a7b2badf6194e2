#include "baton/robot/actuators.hpp"

#include <cmath>
#include <utility>

namespace baton {
namespace {

constexpr double kRounding = 1e-9;    ///< tolerance for accumulated time steps [s]
constexpr double kSpeedTime = 0.003;  ///< low-pass of a servo's differenced speed [s]

}  // namespace

Actuators::Actuators(const RobotModel& robot, const ActuatorErrors& errors, double period, double timestep)
    : robot_(&robot),
      errors_(errors),
      period_(period),
      timestep_(timestep),
      joints_(robot.joints()),
      servos_(joints_.size()) {
  for (Joint& joint : joints_) {
    joint.gains.kp *= errors.kp;
    joint.motor.stall *= errors.strength;
  }
  for (std::size_t j = 0; j < joints_.size(); ++j)
    backlash_.emplace_back(errors.backlash, robot.mj().dof_armature[6 + j]);
}

void Actuators::send(const JointTarget& target, double now) {
  sent_.push_back({now + errors_.delay, target});
}

void Actuators::advance(double now) {
  while (sent_.size() > 1 && sent_[1].arrives <= now + kRounding)
    sent_.pop_front();
  to_end_ = errors_.held_targets ? 0.0 : sent_.front().arrives + period_ - now;
}

Actuators::Torque Actuators::torque(std::size_t joint, double q, double dq) {
  const Joint& own = joints_[joint];
  Servo& servo = servos_[joint];
  const bool begins = !std::exchange(servo.runs, true);
  if (errors_.differenced_speeds) {
    if (!begins) servo.dq += -std::expm1(-timestep_ / kSpeedTime) * ((q - servo.q) / timestep_ - servo.dq);
    servo.q = q;
    dq = servo.dq;
  }
  const ServoCommand command = servo_command(*robot_, joint, sent_.front().target, to_end_);
  const double asked = motor_torque(own.motor, errors_.gain * servo_torque(own.gains, command, q, dq));
  if (begins || errors_.lag == 0.0) {
    servo.torque = asked;
  } else {
    servo.torque += -std::expm1(-timestep_ / errors_.lag) * (asked - servo.torque);
  }
  return {servo.torque, backlash_[joint].transmit(servo.torque, timestep_)};
}

}  // namespace baton
