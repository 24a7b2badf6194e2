/// How hot the motors are, by the torques that they give, and whether the robot has to let them cool. There is no
/// sensor for it: a robot that is switched on counts as cold.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/model/heat.hpp"
#include "baton/motion/motion.hpp"
#include "baton/plan/request.hpp"

namespace baton {

class Thermometer {
 public:
  /// The robot must outlive the object.
  explicit Thermometer(const RobotModel& robot);

  /// Advances by one tick. Allocates nothing.
  /// @param measured believed; a torque that is not finite, or beyond what the motor can give, counts as commanded
  /// @param commanded joint targets of this tick
  void update(const Measurement& measured, const JointTarget& commanded);

  /// Of all motors (n).
  [[nodiscard]] const Heat& heat() const { return heat_; }
  [[nodiscard]] Hottest hottest() const { return baton::hottest(heat_); }
  /// Whether a motor is so hot that nothing new is begun before it has cooled down: hysteresis from `kHot` to 0.7, or
  /// to where it gets no cooler, if the rest keeps it above that.
  [[nodiscard]] bool hot() const { return hot_; }

 private:
  void judge();

  const RobotModel* robot_;
  HeatModel model_;
  Heat heat_;
  VecX torque_;  ///< of the currents (n) [N·m]
  bool hot_ = false;
  double hot_time_ = 0.0;   ///< for which the robot has been hot [s]
  double hot_from_ = kHot;  ///< rise at which it is hot [permitted rise]
};

}  // namespace baton
