/// Contact wrenches: ZMP, support polygon, distribution between the soles, joint torques.
#pragma once

#include "baton/model/kinematics.hpp"

namespace baton {

/// Force and moment of the ground on the robot; the moment is about the origin of the frame.
struct Wrench {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 moment = Vec3::Zero();  ///< [N·m]

  /// The moment about `point` [N·m].
  [[nodiscard]] Vec3 moment_about(const Vec3& point) const { return moment - point.cross(force); }
  /// ZMP on the plane z = height [m]. NaN unless the vertical force is positive.
  [[nodiscard]] Vec2 zmp(double height) const;

  bool operator==(const Wrench&) const = default;
};

/// The total contact wrench, about the frame's origin, that a motion needs.
/// @param kinematics set to the configuration
/// @param force generalised forces there, by inverse dynamics without contact (nv)
[[nodiscard]] Wrench ground_wrench(const Kinematics& kinematics, const VecX& force);

/// The wrench that a robot needs whose COM is off the model's by `offset` [m]: the ZMP is shifted by as much.
[[nodiscard]] Wrench with_com_offset(Wrench wrench, const Vec2& offset);

/// Outline of a sole, projected onto the horizontal plane.
[[nodiscard]] ConvexPolygon sole_outline(const RobotModel& robot, Side side, const Pose& sole);

/// Hull of the vertices of the soles in contact, projected from the COM onto the plane z = height
/// (docs/theory.md §3); exact for soles on that plane.
[[nodiscard]] ConvexPolygon support_polygon(const RobotModel& robot, const BySide<Pose>& sole,
                                            const BySide<bool>& contact, const Vec3& com, double height);

/// Whether the soles in contact lie in the plane z = height. Their support polygon is then independent of the COM.
[[nodiscard]] bool on_one_plane(const BySide<Pose>& sole, const BySide<bool>& contact, double height);

/// Height of the lower sole in contact [m].
[[nodiscard]] double support_plane(const BySide<Pose>& sole, const BySide<bool>& contact);

/// Distributes `total` between the soles in contact. The load follows from where the ZMP lies between them, such that
/// each sole's centre of pressure is as far inside the sole as possible (docs/theory.md §6). Moments about the origin.
[[nodiscard]] BySide<Wrench> share_wrench(const RobotModel& robot, const BySide<Pose>& sole,
                                          const BySide<bool>& contact, const Wrench& total);

/// Joint torques τ = ID − Jᵀf (n) [N·m].
/// @param kinematics set to the configuration
/// @param force generalised forces by inverse dynamics without contact (nv)
/// @param contact wrench on each sole, moment about the origin
void joint_torques(const Kinematics& kinematics, const VecX& force, const BySide<Wrench>& contact, VecX& tau);

/// Subtracts the torques Jᵀf of the contact wrenches from `tau` (n) [N·m].
/// @param kinematics set to the configuration
/// @param contact wrench on each sole, moment about the origin
void subtract_contact(const Kinematics& kinematics, const BySide<Wrench>& contact, VecX& tau);

/// Scales the moments about the feet's last joints, the ankles: a robot that hangs would point its toes for them.
/// @param kinematics set to the configuration
/// @param contact wrench on each sole, moment about the origin
void scale_ankle_moments(const Kinematics& kinematics, double factor, BySide<Wrench>& contact);

}  // namespace baton
