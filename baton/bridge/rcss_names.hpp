/// What rcssservermj calls a robot and its joints: its own model of the robot says so.
#pragma once

#include <string>
#include <vector>

#include "baton/bridge/rcss_message.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::bridge {

struct RcssNames {
  std::string robot;              ///< name of its model: "K1"
  std::vector<RcssJoint> joints;  ///< ordered as in the robot
};

/// Reads the robot's model file. The angle of a joint is perceived by the sensor of its position (`jointpos`), and it
/// is driven by the motor `…_tau`; sign and zero are the model's.
/// @throws InputError the model is none of the simulator's: a joint has no such sensor or motor
[[nodiscard]] RcssNames rcss_names(const RobotModel& robot);

}  // namespace baton::bridge
