/// Rests → calibration: the constant errors of the sensors with which the readings of all rests agree best.
#pragma once

#include <span>
#include <vector>

#include "baton/calibrate/rest.hpp"
#include "baton/robot/calibration.hpp"

namespace baton {

struct Estimate {
  Calibration calibration;   ///< of the legs, the IMU and the force sensors; 0 for other joints
  Calibration sigma;         ///< standard deviation of each of its numbers
  Calibration prior;         ///< the same before the rests
  double play = 0.0;         ///< play (backlash) to each side, the same for all joints [rad]
  double play_sigma = 0.0;   ///< [rad]
  double yield = 0.0;        ///< of the hips' abduction [rad per weight × COM height]
  double yield_sigma = 0.0;  ///< [rad per weight × COM height]
  double misfit = 0.0;  ///< rms of the residuals in their standard deviations: at most about 1 if all is as assumed
};

/// Joints of both legs, whose zeros are estimated: indices into `RobotModel::joints()`, each once.
[[nodiscard]] std::vector<int> leg_joints(const RobotModel& robot);

/// Maximum a posteriori, by the method of Gauss and Newton (docs/calibration.md). The prior is what the profile says of
/// sensors and actuators.
/// @param rests on level ground, as `Posing` makes them
/// @throws InputError the robot has no IMU, or no errors explain the rests: a reading is not finite, say
[[nodiscard]] Estimate estimate(const RobotModel& robot, std::span<const Rest> rests);

}  // namespace baton
