/// The limits that a motion is planned within and verified against.
#pragma once

#include "baton/model/profile.hpp"

namespace baton {

/// Margins of a motion, derived from the robot's profile. Each factory function below suits one situation. Joint speeds
/// are limited by `Joint::speed`; the margins of goals and balance are read from the profile itself.
struct Limits {
  double zmp_plan = 0.0;          ///< least margin of the point-mass ZMP inside the support polygon [m]
  double zmp_outward = 0.0;       ///< the same from the outer edges of the soles, if more [m]
  double zmp_verify = 0.0;        ///< the same for the whole-body ZMP [m]
  Vec2 com_offset{Vec2::Zero()};  ///< of the robot's COM from the model's, in the planning frame [m]
  double joint = 0.0;             ///< least distance of a joint from its position limits [rad]
  double torque = 0.0;            ///< largest share of the stall torque
  double acceleration = 0.0;      ///< largest joint acceleration [rad/s²]
  double heat = 0.0;              ///< largest rise of a winding's temperature [permitted rise]
  double friction = 0.0;          ///< largest ratio of tangential to normal contact force
  double self_collision = 0.0;    ///< least distance between links [m]
  double swing_clearance = 0.0;   ///< swing apex above the higher foothold [m]
  double swing_time = 0.0;        ///< shortest swing of a step [s]

  /// The profile's values.
  [[nodiscard]] static Limits normal(const Profile& profile);

  /// For ground that is not as mapped. A sole may be supported on part of its area only, so the planned ZMP keeps a
  /// larger margin.
  [[nodiscard]] static Limits uneven_ground(const Profile& profile);

  /// For a capture step. Margins that make a plan easy to track are relaxed (ZMP, torque, acceleration, swing), and so
  /// is heat, as a fall costs more; those that the next motion starts from are not (joint range, distances, edges).
  [[nodiscard]] static Limits push_recovery(const Profile& profile);

  bool operator==(const Limits&) const = default;
};

}  // namespace baton
