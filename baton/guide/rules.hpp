/// Internal to the guide: what its source files share.
///
/// - `guide.cpp`: selection of the rule; goals common to all rules; going home
/// - `guide_foot.cpp`, `guide_trunk.cpp`, `guide_hand.cpp`: the guiding rule of each part
/// - `placement.cpp`: valid footholds
/// - `landing.cpp`: landings, stops, standing straighter, capture steps
#pragma once

#include "baton/guide/guide.hpp"

namespace baton {

/// A foothold, or the reason why it is invalid.
struct Guide::Placement {
  Pose sole;
  std::optional<Refusal> refusal;
};

inline constexpr double kSamePlace = 0.004;  ///< places closer than this are the same [COM height]
inline constexpr double kSameYaw = 0.01;     ///< headings closer than this are the same [rad]
inline constexpr double kSameDirection =
    0.7;  ///< two directions count as the same if the cosine of their angle is larger

/// Least lift of a foot in the air [m]. Just above the ground it would scrape as soon as it lags behind its plan.
[[nodiscard]] inline double least_lift(const Profile& profile) {
  return 0.25 * profile.swing.clearance;
}

/// Attitude without its yaw.
[[nodiscard]] inline Mat3 inclination(const Mat3& R) {
  return rotation_z(-yaw_of(R)) * R;
}

/// The attitude with its tilt reduced to `most` [rad] if it is larger, in the plane that it leans in.
[[nodiscard]] inline Mat3 limit_tilt(const Mat3& R, double most) {
  const double excess = tilt_of(R) - most;
  if (!(excess > 0.0)) return R;
  return rotation_exp(R.col(2).cross(Vec3::UnitZ()).normalized() * excess) * R;
}

}  // namespace baton
