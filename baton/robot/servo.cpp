#include "baton/robot/servo.hpp"

#include <algorithm>

namespace baton {

ServoCommand servo_command(const RobotModel& robot, std::size_t joint, const JointTarget& target, double to_end) {
  const auto i = static_cast<Eigen::Index>(joint);
  const double shift = i < target.q_correction.size() ? target.q_correction[i] : 0.0;
  const Profile::Gains& gains = robot.joints()[joint].gains;
  ServoCommand command{target.q[i] + shift - to_end * target.dq[i], target.dq[i], 0.0};
  switch (robot.profile().drive) {
    case Drive::torque:
      command.tau = target.tau[i];
      break;
    case Drive::pd:
      command.q += target.tau[i] / gains.kp;
      break;
    case Drive::stiff:
      command.q += (target.tau[i] + gains.kd * target.dq[i]) / gains.kp;
      command.dq = 0.0;
      break;
  }
  return command;
}

double servo_torque(const Profile::Gains& gains, const ServoCommand& command, double q, double dq) {
  return command.tau + gains.kp * (command.q - q) + gains.kd * (command.dq - dq);
}

double motor_torque(const Motor& motor, double asked) {
  return std::clamp(asked, -motor.stall, motor.stall);
}

}  // namespace baton
