/// A gantry from which a simulated robot hangs.
#pragma once

#include "baton/model/kinematics.hpp"
#include "baton/robot/robot_in_world.hpp"

namespace baton {

/// A rope to each shoulder, from straight above it. Ropes only pull, up. While they are taut, the hands of those who
/// steady the robot damp its swinging and keep its trunk nearly as upright as it was at first.
class Gantry {
 public:
  /// It carries the robot where the robot is.
  /// @param kinematics set to that configuration
  /// @param model of robot and world
  Gantry(const RobotModel& robot, const Kinematics& kinematics, const mjModel& model);

  /// Raises the ropes, or lowers them, from now on, at a speed that people use.
  /// @param height above where they were first [m]
  void move(double height) { goal_ = height; }

  /// Adds the ropes' forces for one step to `qfrc_applied`, which it sets to zero first.
  void pull(const mjModel& model, mjData& data);

 private:
  struct Rope {
    Vec3 on_trunk;  ///< where it is tied, in the trunk's frame [m]
    Vec3 above;     ///< its upper end at first, in the world [m]
  };

  double weight_, length_, speed_ = 0.0, damping_ = 0.0, turning_ = 0.0;
  int trunk_ = 0;  ///< body of the model of robot and world
  Mat3 upright_;   ///< attitude of the trunk at first
  BySide<Rope> rope_;
  double height_ = 0.0, goal_ = 0.0;
};

}  // namespace baton
