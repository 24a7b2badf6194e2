/// Servos and motors of a simulated robot: joint targets → torques, with deviations from the profile.
#pragma once

#include <deque>
#include <vector>

#include "baton/robot/servo.hpp"

namespace baton {

/// How the actuators deviate from the profile.
struct ActuatorErrors {
  double gain = 1.0;      ///< factor on the commanded motor torque
  double strength = 1.0;  ///< factor on the stall torque
  double kp = 1.0;        ///< factor on the servos' stiffness
  double delay = 0.0;     ///< between sending a joint target and its arrival at the servos [s]
};

class Actuators {
 public:
  /// `robot` must outlive this object.
  /// @param period of the joint targets [s]
  Actuators(const RobotModel& robot, const ActuatorErrors& errors, double period);

  /// Sends a target to the servos.
  /// @param now [s]
  void send(const JointTarget& target, double now);

  /// Makes the newest target that has arrived by `now` [s] active. `now` must not decrease.
  void advance(double now);

  /// Motor torque at the time of the last `advance` [N·m]. Requires a target.
  /// @param q encoder angle [rad]
  /// @param dq speed [rad/s]
  [[nodiscard]] double torque(std::size_t joint, double q, double dq) const;

 private:
  /// A target in transit, or active.
  struct Sent {
    double arrives = 0.0;  ///< [s]
    JointTarget target;
  };

  const RobotModel* robot_;
  ActuatorErrors errors_;
  double period_;
  std::vector<Joint> joints_;  ///< with the actual gains and motors
  std::deque<Sent> sent_;      ///< the front one is active
  double to_end_ = 0.0;        ///< time left in the tick of the active target [s]
};

}  // namespace baton
