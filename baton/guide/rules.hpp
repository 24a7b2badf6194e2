/// What the guiding rules share. Internal to the guide: they are members of `Guide`, in a file for each job.
///
/// - `guide.cpp`: which rule a command asks for; goals that all rules begin with
/// - `guide_foot.cpp`, `guide_trunk.cpp`, `guide_hand.cpp`: the guiding rule of each part
/// - `placement.cpp`: where a foot can stand
/// - `landing.cpp`: how a foot comes down, and how the robot comes to rest or catches itself
#pragma once

#include "baton/guide/guide.hpp"

namespace baton {

/// A foot somewhere, and what speaks against it.
struct Guide::Placement {
  Pose sole;
  std::optional<Refusal> against;
};

inline constexpr double kSamePlace = 1e-3;  ///< nearer to each other two places are one, for any size of robot [m]
inline constexpr double kSameYaw = 0.01;    ///< nearer to each other two headings are one [rad]
inline constexpr double kLeads = 0.7;       ///< cosine of the angle up to which two ways lead the same way

/// Attitude with the yaw taken out: how the trunk leans.
[[nodiscard]] inline Mat3 inclination(const Mat3& R) {
  return rotation_z(-yaw_of(R)) * R;
}

/// An attitude that leans by `most` at most [rad]: set upright in the plane it leans in.
[[nodiscard]] inline Mat3 leaning(const Mat3& R, double most) {
  const double excess = tilt_of(R) - most;
  if (!(excess > 0.0)) return R;
  return rotation_exp(R.col(2).cross(Vec3::UnitZ()).normalized() * excess) * R;
}

/// The end of a range that a value outside it is nearest to.
[[nodiscard]] inline double nearest_limit(double value, const Range& range) {
  return value < range.lo ? range.lo : range.hi;
}

}  // namespace baton
