/// Leg odometry: dead reckoning of the root by the soles in contact, and by its acceleration while there is none.
#pragma once

#include "baton/balance/sole_contact.hpp"

namespace baton {

class LegOdometry {
 public:
  /// The robot must outlive the object.
  /// @param root initial position of the root, in the world [m]
  /// @param sole initial positions of the soles, at rest, in the world [m]
  LegOdometry(const RobotModel& robot, const Vec3& root, const BySide<Vec3>& sole);

  /// Updates the estimate, once a tick.
  /// @param kinematics set to the configuration with the root at the origin, at its measured attitude
  /// @param dq velocity (nv), with zero linear velocity of the root
  /// @param acceleration of the root's origin, in the world [m/s²]
  /// @param wrench on each sole, in its frame, moment about its centre: a lightly loaded sole that tilts pivots about
  /// its centre of pressure, any other about its centre
  void update(const Kinematics& kinematics, const VecX& dq, const Vec3& acceleration, const SoleContact& contact,
              const BySide<Wrench>& wrench);

  /// Moves the root and the footholds [m].
  void shift(const Vec3& by);

  /// Position of the root, in the world [m].
  [[nodiscard]] const Vec3& place() const { return place_; }
  /// Velocity of the root's origin, in the world [m/s].
  [[nodiscard]] const Vec3& velocity() const { return velocity_; }
  /// Positions of the soles: of the foothold for a sole in contact, else of the sole itself [m].
  [[nodiscard]] const BySide<Vec3>& foothold() const { return foothold_; }
  /// Horizontal distance walked, from foothold to foothold, both feet added up [m].
  [[nodiscard]] double walked() const { return walked_; }

 private:
  /// The point about which a sole in contact tilts, in its frame [m].
  [[nodiscard]] Vec3 pivot(Side side, const Wrench& wrench) const;

  const RobotModel* robot_;
  double period_;
  JacobianRows jacobian_;
  bool first_ = true;
  Vec3 place_;
  Vec3 velocity_ = Vec3::Zero();  ///< [m/s]
  BySide<Vec3> foothold_;
  BySide<Mat3> sole_;                        ///< attitude of the soles one tick ago
  BySide<Vec3> footfall_;                    ///< latest positions in contact [m]
  BySide<bool> touched_before_{true, true};  ///< contacts one tick ago
  double walked_ = 0.0;
};

}  // namespace baton
