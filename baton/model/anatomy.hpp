/// Finds the parts of a humanoid in a model that it has never seen: no names are looked at, save that of an IMU.
#pragma once

#include <string>
#include <vector>

#include "baton/math/polygon.hpp"
#include "baton/model/mujoco.hpp"
#include "baton/model/side.hpp"

namespace baton {

/// A pose as MuJoCo holds it: position (3), quaternion wxyz (4).
[[nodiscard]] Pose local_pose(const mjtNum* pos, const mjtNum* quat);

/// The last body that two bodies hang from, or one of them.
[[nodiscard]] int common_ancestor(const mjModel& model, int a, int b);

/// What stands on the ground: the part of a foot that touches a plane.
struct SoleShape {
  double height = 0.0;         ///< lowest point in the foot's frame, along the given normal [m]
  Vec2 centre = Vec2::Zero();  ///< of the outline's bounding box [m]
  ConvexPolygon outline;       ///< about the centre [m]
  std::vector<int> geoms;      ///< colliders of the foot
};

/// The sole of a body: the convex hull of the points of its colliders that are lowest along z of `frame`, within a
/// hundredth of the foot's length. Planes of any geom are found: box, sphere, capsule, cylinder, ellipsoid, mesh.
/// @param frame of the sole's attitude, in the body (x forward, z the normal)
/// @return an empty outline if there is no collider
[[nodiscard]] SoleShape sole_shape(const mjModel& model, int body, const Pose& frame);

/// Half of what a sole's outline measures across, along y [m].
[[nodiscard]] double half_width(const ConvexPolygon& outline);

/// A robot's parts: indices of bodies. −1: not found.
struct Anatomy {
  BySide<int> foot{-1, -1};
  BySide<int> hand{-1, -1};
  BySide<int> shoulder{-1, -1};
  int trunk = -1;
  std::string imu;                   ///< site on the first body, "" if there is none
  std::vector<std::string> fingers;  ///< joints beyond the hands
  std::string no_legs;               ///< why no feet were found; "" if they were
  std::string no_arms;               ///< the same for hands and shoulders
};

/// Finds feet, hands, shoulders, trunk and IMU at q = 0, where the root's x points forward and its z up.
///
/// - Feet: the two lowest ends of chains of at least six hinges, one on each side.
/// - Arms: the two heaviest limbs that lie wholly on one side, legs aside, of at least two hinges. A limb's first body
///   is the shoulder; the hand is where the limb branches into fingers, or its end, but at most the seventh joint.
/// - Trunk: the last body that both shoulders hang from.
/// - IMU: the site of a gyro on the first body, else a site there whose name has "imu" in it.
[[nodiscard]] Anatomy find_parts(const mjModel& model);

}  // namespace baton
