/// A robot with perfect tracking on rigid ground: its joints reach their targets at the end of the tick, and stance
/// soles do not move.
#pragma once

#include "baton/robot/robot.hpp"

namespace baton {

class IdealRobot : public Robot {
 public:
  /// @param start initial standing posture, in the world frame
  IdealRobot(const RobotModel& robot, const Posture& start, double period);

  [[nodiscard]] Measurement read() override;
  void write(const JointTarget& target) override;
  void reset() override;
  [[nodiscard]] const Truth* truth() const override { return &truth_; }

 private:
  void measure_ground(const VecX& ddq);
  /// Velocity of the IMU in the world frame, given the root's attitude [m/s].
  [[nodiscard]] Vec3 sensor_velocity(const Mat3& root) const;

  const RobotModel* robot_;
  Posture start_;
  double period_;
  Kinematics kinematics_;
  Side planted_ = Side::left;  ///< the stance sole that the kinematic chain starts from
  BySide<Pose> sole_;          ///< in the world frame
  BySide<bool> contact_{true, true};
  Truth truth_;
  Pose sensor_;                       ///< IMU in the root frame
  Vec3 velocity_ = Vec3::Zero();      ///< IMU velocity one tick ago [m/s]
  Vec3 acceleration_ = Vec3::Zero();  ///< mean IMU acceleration over the last tick [m/s²]
  VecX torque_;
};

}  // namespace baton
