/// What the paper argues against: the guided point follows the stick's velocity, the COM stays above the support, and
/// inverse kinematics does the rest at every tick. Nothing is planned and nothing verified.
#pragma once

#include "baton/guide/command.hpp"
#include "baton/ik/inverse_kinematics.hpp"
#include "baton/motion/posture.hpp"

namespace baton::bench {

/// On level ground at height 0.
///
/// At full stick a part goes its reach in each of the profile's default durations; velocities are smoothed by the time
/// constant of the pendulum, and what no stick moves goes to its place no faster either. A guided foot is up while its
/// throttle or the stick is away from zero: as high as the throttle says, or by the clearance of a step. A foot that is
/// not guided goes down where it is; two are never up. The COM is above the stance foot from when the other one is to
/// rise until it stands, above the middle of the feet else, unless the trunk is guided; its height is kept. The trunk
/// is upright unless guided, in the feet's mean heading. Hands that are not guided keep the angles of their arms.
class VelocityTracking {
 public:
  /// How much it takes care by itself.
  enum class Care {
    none,
    regions,  ///< parts slow down before they leave the profile's regions, and a foot rises only once the COM is above
              ///< the other one
  };

  /// @param robot must outlive the object
  VelocityTracking(const RobotModel& robot, const Posture& start, Care care);

  void tick(const Command& command);

  [[nodiscard]] const VecX& q() const { return q_; }
  /// Where feet and COM should be.
  [[nodiscard]] const IkTargets& targets() const { return targets_; }
  [[nodiscard]] const BySide<bool>& contact() const { return contact_; }

 private:
  void move_foot(Side side, const Command& command, const Mat3& heading);
  void move_com(const Command& command, const Mat3& heading);
  void move_trunk(const Command& command, const Mat3& heading);
  void move_hands(const Command& command, const Mat3& heading);
  [[nodiscard]] bool wants_up(Side side, const Command& command) const;
  /// Brings a velocity nearer to the one that is asked for.
  void smooth(Vec3& velocity, const Vec3& wanted) const;
  /// The velocity that leads to a place, no faster than `speed`.
  [[nodiscard]] static Vec3 towards(const Vec3& difference, double speed);

  const RobotModel* robot_;
  Care care_;
  double dt_;
  double T_;      ///< default duration [s]
  double share_;  ///< of the way to a wanted velocity, by which a tick brings one nearer to it
  InverseKinematics ik_;
  IkTargets targets_;
  BySide<bool> contact_{true, true};
  double height_;              ///< of the COM over the ground [m]
  std::optional<Side> rises_;  ///< a foot that is up or about to be
  BySide<Vec3> foot_velocity_{Vec3::Zero(), Vec3::Zero()}, hand_velocity_{Vec3::Zero(), Vec3::Zero()};
  Vec3 com_velocity_ = Vec3::Zero();
  BySide<double> yaw_rate_{0.0, 0.0};
  Vec3 trunk_rate_ = Vec3::Zero();
  VecX q_, before_;
};

}  // namespace baton::bench
