/// DCM feedback: planned sample and measured state → joint command. Feed-forward torque from a bounded correction of
/// the contact wrench, and joint angles adapted to the terrain (docs/theory.md §6).
#pragma once

#include "baton/balance/footing.hpp"
#include "baton/balance/joint_friction.hpp"
#include "baton/balance/torque_scale.hpp"
#include "baton/balance/wrench_distribution.hpp"

namespace baton {

/// The stabiliser's latest correction, for the navigator and for recording.
struct Correction {
  Vec3 dcm_error = Vec3::Zero();    ///< measured − planned DCM, in the planning frame [m]
  Vec2 zmp = Vec2::Zero();          ///< commanded ZMP, in the planning frame [m]
  Vec2 zmp_deficit = Vec2::Zero();  ///< commanded − measured ZMP, low-passed: what the terrain fails to support [m]
  /// Estimated offset of the COM from the model's, horizontal, in the planning frame: measured − planned ZMP,
  /// low-passed, beyond a dead band [m]. It stands for payload, COM errors and a tilted IMU, which a standing robot
  /// cannot tell apart.
  Vec2 com_offset = Vec2::Zero();
  /// Whether after a start joints are still led to the plan, or `com_offset` has not converged: until then no motion is
  /// begun from rest, except to catch the robot.
  bool settling = false;
};

class Stabiliser {
 public:
  /// The robot must outlive the object.
  explicit Stabiliser(const RobotModel& robot);

  /// Joint command for the end of this tick.
  /// @param now planned sample at the time of the measurement
  /// @param next planned sample at the end of this tick
  /// @param stands how far the robot stands by itself, from 0 to 1: less while it hangs. Corrections and the moments at
  /// the ankles are scaled by it; below 1 nothing is learned
  /// @param play of the joints, to each side [rad]
  [[nodiscard]] const JointTarget& target(const MotionSample& now, const MotionSample& next, const State& state,
                                          double stands = 1.0, double play = 0.0);

  /// Resets everything learned about terrain and motors.
  void reset();

  [[nodiscard]] const Footing& footing() const { return footing_; }
  [[nodiscard]] const Correction& correction() const { return correction_; }

 private:
  /// Updates the difference between commanded and measured ZMP.
  void compare_zmp(const MotionSample& now, const State& state);
  /// @param measured ZMP [m]
  void update_com_offset(const MotionSample& now, const Vec2& measured);
  /// Horizontal moment that turns the trunk to its planned attitude and rate [N·m].
  /// @param trunk planned attitude, one tick after `trunk_`
  [[nodiscard]] Vec2 attitude_moment(const Mat3& trunk, const State& state) const;
  /// Adds to `unloaded_` what makes waist, neck and arms follow when the wrench from the ground accelerates the body:
  /// the legs act on the first body alone.
  /// @param force, moment correction of that wrench, moment about the COM [N, N·m]
  void carry_upper_body(const Vec3& force, const Vec3& moment);
  /// Updates friction, torque scale and integral action of the joints.
  void update_joints(const MotionSample& now, const State& state);
  /// What verified motions leave of a joint's stall torque [N·m].
  [[nodiscard]] double spare_torque(int joint) const;
  /// Torque of integral action and friction, at most the spare torque [N·m].
  [[nodiscard]] double learned_torque(int joint, double planned_speed) const;
  /// Sends the motors past their links, to the side of the play to which their torque is to push.
  void lead_through_play(double play);
  /// Leads the commanded joint angles from where the joints are at a start to where the plan has them, smoothly.
  void approach_plan();

  const RobotModel* robot_;
  Kinematics kinematics_;
  Footing footing_;
  WrenchDistribution distribution_;
  VecX commanded_;                 ///< latest commanded angles of the links, including footing (n) [rad]
  VecX lead_;                      ///< by how much the motors are sent past them (n) [rad]
  Mat3 trunk_ = Mat3::Identity();  ///< its planned attitude at the time of the measurement
  VecX unloaded_;                  ///< joint torques without contact (n) [N·m]
  VecX learned_;                   ///< torques of integral action and friction (n) [N·m]
  VecX modelled_;                  ///< joint torques without anything learned (n) [N·m]
  VecX apart_;                ///< where the joints were at the start, less the plan, as far as that is a jump (n) [rad]
  double approaching_ = 0.0;  ///< time since the start, while they are led to the plan [s]
  VecX servo_error_;          ///< commanded − measured joint angles (n) [rad]
  VecX integral_torque_;      ///< torque of the integral action (n) [N·m]
  JointFriction friction_;
  TorqueScale scale_;
  std::vector<int> upper_;  ///< joints that move neither foot
  bool waist_;              ///< whether joints lie between the root and the trunk
  BySide<Wrench> wanted_;   ///< desired wrench on each sole, in the axes of the planning frame, moment about its centre
  bool first_ = true;
  JointTarget target_;
  Correction correction_;
  Vec2 steady_zmp_ = Vec2::Zero();  ///< measured − planned ZMP, in the heading frame [m]
  double averaged_;                 ///< time over which it is averaged [1/ω]
};

}  // namespace baton
