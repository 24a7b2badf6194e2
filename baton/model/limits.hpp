/// The limits that a motion is held to: planned inside them, verified against them.
#pragma once

#include "baton/model/profile.hpp"

namespace baton {

/// Every margin of a motion, all from the robot's profile; what differs with the occasion is up to the maker. Speeds
/// are limited by `Joint::speed`; what goals and balance keep to stays in the profile.
struct Limits {
  double zmp_plan = 0.0;         ///< least distance of the point mass's ZMP from the edge of the support polygon [m]
  double zmp_verify = 0.0;       ///< the same of the whole body's ZMP [m]
  double joint = 0.0;            ///< least distance of a joint from its position limits [rad]
  double torque = 0.0;           ///< largest share of the stall torque
  double acceleration = 0.0;     ///< largest of a joint [rad/s²]
  double friction = 0.0;         ///< largest tangential over normal contact force
  double self_collision = 0.0;   ///< least distance of two links, or of a link and the world [m]
  double edge = 0.0;             ///< least distance of a foothold from an edge of the ground [m]
  double swing_clearance = 0.0;  ///< apex of the swing foot above the higher end of its step [m]
  double swing_time = 0.0;       ///< shortest time that a foot is in the air on a step [s]

  /// The profile's own.
  [[nodiscard]] static Limits normal(const Profile& profile);

  /// On ground that is not what the map says: a sole may stand on a part of it only, so the planned ZMP keeps farther
  /// inside.
  [[nodiscard]] static Limits uneven_ground(const Profile& profile);

  /// Of a step that catches a pushed robot. It may use up what makes a plan easy to follow (ZMP, torque, acceleration,
  /// the swing), not what the next motion needs to begin (joints, distances, edges).
  [[nodiscard]] static Limits push_recovery(const Profile& profile);

  bool operator==(const Limits&) const = default;
};

}  // namespace baton
