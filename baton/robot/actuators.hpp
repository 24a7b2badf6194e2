/// Servos and motors of a simulated robot: joint targets → torques, with deviations from the profile.
#pragma once

#include <deque>
#include <vector>

#include "baton/model/hardware_errors.hpp"
#include "baton/robot/backlash.hpp"
#include "baton/robot/servo.hpp"

namespace baton {

class Actuators {
 public:
  /// `robot` must outlive this object.
  /// @param period of the joint targets [s]
  /// @param timestep of the servos [s]
  Actuators(const RobotModel& robot, const ActuatorErrors& errors, double period, double timestep);

  /// Sends a target to the servos.
  /// @param now [s]
  void send(const JointTarget& target, double now);

  /// Makes the newest target that has arrived by `now` [s] active. `now` must not decrease.
  void advance(double now);

  /// Angle [rad] and speed [rad/s] of the motor beyond those of the link.
  [[nodiscard]] const Backlash& backlash(std::size_t joint) const { return backlash_[joint]; }

  /// Torques of one joint.
  struct Torque {
    double motor = 0.0;  ///< [N·m]
    double link = 0.0;   ///< what arrives at the link [N·m]
  };

  /// Torques for the time step from the last `advance` on. Requires a target. Call it once per time step and joint.
  /// @param q encoder angle [rad]
  /// @param dq true speed of the motor [rad/s]
  [[nodiscard]] Torque torque(std::size_t joint, double q, double dq);

 private:
  /// A target in transit, or active.
  struct Sent {
    double arrives = 0.0;  ///< [s]
    JointTarget target;
  };

  /// A servo's own differencing, and the lag of its motor.
  struct Servo {
    double q = 0.0;       ///< last encoder angle [rad]
    double dq = 0.0;      ///< filtered speed [rad/s]
    double torque = 0.0;  ///< of the motor [N·m]
    bool runs = false;
  };

  const RobotModel* robot_;
  ActuatorErrors errors_;
  double period_;
  double timestep_;
  std::vector<Joint> joints_;  ///< with the actual gains and motors
  std::vector<Servo> servos_;
  std::vector<Backlash> backlash_;
  std::deque<Sent> sent_;  ///< the front one is active
  double to_end_ = 0.0;    ///< time left in the tick of the active target [s]
};

}  // namespace baton
