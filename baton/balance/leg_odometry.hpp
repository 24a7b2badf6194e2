/// Dead reckoning of the root by the soles that stand, and by its acceleration while none does.
#pragma once

#include "baton/balance/sole_contact.hpp"

namespace baton {

class LegOdometry {
 public:
  /// The robot must outlive the object.
  /// @param root where the root is to begin with [m]
  /// @param sole where the soles are, at rest [m]
  LegOdometry(const RobotModel& robot, const Vec3& root, const BySide<Vec3>& sole);

  /// One tick.
  /// @param kinematics the robot with its root at the origin, in its attitude
  /// @param dq its velocity (nv), with that of the root's origin zero
  /// @param acceleration of the root's origin, in the world [m/s²]
  void update(const Kinematics& kinematics, const VecX& dq, const Vec3& acceleration, const SoleContact& contact);

  /// Corrects the place of the root, and of the soles with it [m].
  void shift(const Vec3& by);

  /// Of the root, in the world [m].
  [[nodiscard]] const Vec3& place() const { return place_; }
  [[nodiscard]] const Vec3& velocity() const { return velocity_; }
  /// Where the soles stand, or are [m].
  [[nodiscard]] const BySide<Vec3>& foothold() const { return foothold_; }
  /// Way that both feet have gone, from footfall to footfall [m].
  [[nodiscard]] double gone() const { return gone_; }

 private:
  const RobotModel* robot_;
  double period_;
  JacobianRows jacobian_;
  bool first_ = true;
  Vec3 place_;
  Vec3 velocity_ = Vec3::Zero();  ///< [m/s]
  BySide<Vec3> foothold_;
  BySide<Vec3> footfall_;             ///< where the soles stood last [m]
  BySide<bool> touched_{true, true};  ///< a tick ago
  double gone_ = 0.0;
};

}  // namespace baton
