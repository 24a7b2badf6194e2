/// Servos and motors of a simulated robot: joint targets → torques, with what is different about them from the profile.
#pragma once

#include <deque>
#include <vector>

#include "baton/robot/servo.hpp"

namespace baton {

/// How a robot's actuators differ from what the program believes.
struct ActuatorErrors {
  double gain = 1.0;      ///< factor on the torque that a motor is asked for
  double strength = 1.0;  ///< factor on the stall torque
  double kp = 1.0;        ///< factor on the servos' stiffness
  double delay = 0.0;     ///< from the joint targets to the servos [s]
};

class Actuators {
 public:
  /// The robot must outlive the object.
  /// @param period of the joint targets [s]
  Actuators(const RobotModel& robot, const ActuatorErrors& errors, double period);

  /// A target is sent to the servos.
  /// @param now [s]
  void send(const JointTarget& target, double now);

  /// The servos take up the newest target that has arrived by now [s]. Times do not decrease.
  void advance(double now);

  /// Torque that a motor gives, at the time of the last `advance` [N·m]. A target must have been sent.
  /// @param q angle, as the joint's encoder says [rad]
  /// @param dq speed [rad/s]
  [[nodiscard]] double torque(std::size_t joint, double q, double dq) const;

 private:
  /// A target on its way to the servos, or there.
  struct Sent {
    double arrives = 0.0;  ///< [s]
    JointTarget target;
  };

  const RobotModel* robot_;
  ActuatorErrors errors_;
  double period_;
  std::vector<Joint> joints_;  ///< as they are: with their own gains and motors
  std::deque<Sent> sent_;      ///< the first is the one that the servos have
  double to_end_ = 0.0;        ///< of the tick that that one is for [s]
};

}  // namespace baton
