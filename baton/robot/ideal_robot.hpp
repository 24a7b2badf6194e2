/// A robot that does exactly what it is told, on ground that never gives: its joints are at their targets when the
/// tick ends, and a sole that stands does not move.
#pragma once

#include "baton/robot/robot.hpp"

namespace baton {

class IdealRobot : public Robot {
 public:
  /// @param start posture that it stands in, in the world
  IdealRobot(const RobotModel& robot, const Posture& start, double period);

  [[nodiscard]] Measurement read() override;
  void write(const JointTarget& target) override;
  void reset() override;
  [[nodiscard]] const Truth* truth() const override { return &truth_; }

 private:
  void measure_ground(const VecX& ddq);
  /// Of the inertial sensor, in the world, with the root's attitude [m/s].
  [[nodiscard]] Vec3 sensor_velocity(const Mat3& root) const;

  const RobotModel* robot_;
  Posture start_;
  double period_;
  Kinematics kinematics_;
  Side planted_ = Side::left;  ///< the sole that carries the chain
  BySide<Pose> sole_;          ///< where the soles are
  BySide<bool> contact_{true, true};
  Truth truth_;
  Pose sensor_;                       ///< the inertial sensor in the root's frame
  Vec3 velocity_ = Vec3::Zero();      ///< of the sensor, a tick ago [m/s]
  Vec3 acceleration_ = Vec3::Zero();  ///< its mean over the last tick [m/s²]
  VecX torque_;
};

}  // namespace baton
