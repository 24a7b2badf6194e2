/// The baseline that the paper argues against: the guided point follows the stick's velocity, the COM stays above the
/// support, and inverse kinematics runs at every tick, without planning or verification.
#pragma once

#include "baton/guide/command.hpp"
#include "baton/ik/inverse_kinematics.hpp"
#include "baton/motion/posture.hpp"

namespace baton::bench {

/// For level ground at height 0.
///
/// At full stick a part moves by its reach per default duration of the profile; velocities are smoothed with the
/// pendulum's time constant, and parts not moved by the stick return to their targets no faster. A guided foot is up
/// while its throttle or stick is deflected: as high as the throttle commands, or by the step clearance. A foot that is
/// not guided goes straight down; both feet are never up. Unless the trunk is guided, the COM is above the stance foot
/// from before the other foot's liftoff to its touchdown, else above the middle of the feet, at constant height. The
/// trunk is upright unless guided, in the feet's mean heading. Hands that are not guided keep their arm angles.
class VelocityTracking {
 public:
  /// Built-in safeguards.
  enum class Care {
    none,
    regions,  ///< parts slow down at the profile's regions, and a foot lifts off only once the COM is above the other
              ///< one
  };

  /// @param robot must outlive this object
  VelocityTracking(const RobotModel& robot, const Posture& start, Care care);

  void tick(const Command& command);

  [[nodiscard]] const VecX& q() const { return q_; }
  /// Targets of feet and COM.
  [[nodiscard]] const IkTargets& targets() const { return targets_; }
  [[nodiscard]] const BySide<bool>& contact() const { return contact_; }

 private:
  void move_foot(Side side, const Command& command, const Mat3& heading);
  void move_com(const Command& command, const Mat3& heading);
  void move_trunk(const Command& command, const Mat3& heading);
  void move_hands(const Command& command, const Mat3& heading);
  [[nodiscard]] bool wants_up(Side side, const Command& command) const;
  /// Low-pass filters a velocity towards the desired one.
  void smooth(Vec3& velocity, const Vec3& wanted) const;
  /// Velocity towards a target, clamped to `speed`.
  [[nodiscard]] static Vec3 towards(const Vec3& difference, double speed);

  const RobotModel* robot_;
  Care care_;
  double dt_;
  double T_;      ///< default duration [s]
  double share_;  ///< filter gain per tick towards a desired velocity
  InverseKinematics ik_;
  IkTargets targets_;
  BySide<bool> contact_{true, true};
  double height_;              ///< COM height above ground [m]
  std::optional<Side> rises_;  ///< a foot that is up or about to lift off
  BySide<Vec3> foot_velocity_{Vec3::Zero(), Vec3::Zero()}, hand_velocity_{Vec3::Zero(), Vec3::Zero()};
  Vec3 com_velocity_ = Vec3::Zero();
  BySide<double> yaw_rate_{0.0, 0.0};
  Vec3 trunk_rate_ = Vec3::Zero();
  VecX q_, before_;
};

}  // namespace baton::bench
