/// Contact wrenches: the support polygon, the ZMP, and how two soles share a wrench.
#pragma once

#include "baton/model/kinematics.hpp"

namespace baton {

/// Force and moment on the robot from the ground; the moment is about the origin of the frame it is given in.
struct Wrench {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 moment = Vec3::Zero();  ///< [N·m]

  /// The same wrench with its moment about `point`.
  [[nodiscard]] Vec3 moment_about(const Vec3& point) const { return moment - point.cross(force); }
  /// Where the line of force meets the plane z = height [m]. Not finite without vertical force.
  [[nodiscard]] Vec2 zmp(double height) const;
};

/// The wrench (about the frame's origin) that must come from the ground, from the generalised forces of
/// inverse dynamics at the configuration that `kinematics` is set to.
[[nodiscard]] Wrench ground_wrench(const Kinematics& kinematics, const VecX& force);

/// Outline of a sole in the frame's horizontal plane.
[[nodiscard]] ConvexPolygon sole_outline(const RobotModel& robot, Side side, const Pose& sole);

/// Hull of the standing soles, their vertices projected centrally from the COM onto the plane z = height
/// (docs/theory.md §3; exact for soles on that plane).
[[nodiscard]] ConvexPolygon support_polygon(const RobotModel& robot, const BySide<Pose>& sole,
                                            const BySide<bool>& contact, const Vec3& com, double height);

/// Whether the standing soles lie on the plane z = height: then where the COM is does not matter to their hull.
[[nodiscard]] bool on_one_plane(const BySide<Pose>& sole, const BySide<bool>& contact, double height);

/// Height of the lower standing sole [m].
[[nodiscard]] double support_plane(const BySide<Pose>& sole, const BySide<bool>& contact);

/// Shares `total` between the standing soles: the load goes with the place of the ZMP between them, chosen so
/// that each sole's own centre of pressure is as far inside it as possible. Wrenches about the origin.
[[nodiscard]] BySide<Wrench> share_wrench(const RobotModel& robot, const BySide<Pose>& sole,
                                          const BySide<bool>& contact, const Wrench& total);

/// Joint torques τ = ID − Jᵀf of the joints (n), for `force` of inverse dynamics and the soles' wrenches.
void joint_torques(const Kinematics& kinematics, const VecX& force, const BySide<Wrench>& contact, VecX& tau);

}  // namespace baton
