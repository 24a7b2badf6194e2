/// Why a command has no motion, and how far a motion stays from each limit.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "baton/motion/posture.hpp"

namespace baton {

/// Every reason for which a command can be refused (docs/refusals.md says what the operator can do).
enum class Reason {
  // guide: the goal itself
  foot_region,        ///< foothold outside the foot's reachable region
  foot_yaw,           ///< soles turned too far from each other [rad]
  sole_gap,           ///< soles closer than allowed [m]
  ground,             ///< no known, flat ground under the whole sole, away from edges
  com_height,         ///< COM already at the end of its height range [m]
  trunk_inclination,  ///< trunk tilted too far [rad]
  no_progress,        ///< no foothold brings the robot nearer to the goal
  no_landing,         ///< from there the lifted foot could not be put down again
  no_history,         ///< nothing is left to retrace
  inclined_sole,      ///< the sole that would carry alone is inclined, as on an edge [rad]
  // plan and verify: the motion to it
  zmp,                 ///< ZMP nearer to the edge of the support polygon than the margin [m]
  unreachable,         ///< inverse kinematics leaves a residual on feet or COM [m or rad]
  joint_limit,         ///< joint nearer to a position limit than the margin [rad]
  joint_speed,         ///< joint speed over its limit [rad/s]
  joint_acceleration,  ///< the same [rad/s²]
  joint_torque,        ///< share of the stall torque over its limit [-]
  friction,            ///< tangential over normal contact force [-]
  contact_wrench,      ///< share of the weight that no forces at the soles' vertices give [-]
  self_collision,      ///< links closer than allowed [m]
  obstacle,            ///< link nearer to something in the world than allowed [m]
  swing_ground,        ///< swing sole would touch the ground on its way [m]
  not_finite,          ///< a target or a result is not a number
};

inline constexpr std::size_t kReasons = static_cast<std::size_t>(Reason::not_finite) + 1;

[[nodiscard]] constexpr std::string_view to_string(Reason reason) {
  constexpr std::array<std::string_view, kReasons> names{
      "foot_region",    "foot_yaw",    "sole_gap",           "ground",        "com_height", "trunk_inclination",
      "no_progress",    "no_landing",  "no_history",         "inclined_sole", "zmp",        "unreachable",
      "joint_limit",    "joint_speed", "joint_acceleration", "joint_torque",  "friction",   "contact_wrench",
      "self_collision", "obstacle",    "swing_ground",       "not_finite"};
  return names[static_cast<std::size_t>(reason)];
}

/// Whether a longer duration may mend it.
[[nodiscard]] constexpr bool mends_with_time(Reason reason) {
  switch (reason) {
    case Reason::zmp:
    case Reason::joint_speed:
    case Reason::joint_acceleration:
    case Reason::joint_torque:
    case Reason::friction:
    case Reason::contact_wrench:
      return true;
    default:
      return false;
  }
}

/// A command that has no verified motion.
struct Refusal {
  Reason reason = Reason::not_finite;
  Part part = Part::trunk;  ///< the navigation point concerned
  double value = 0.0;       ///< what the motion would have needed
  double limit = 0.0;       ///< what is allowed
  std::string where;        ///< joint, link pair or place; may be empty
  double t = 0.0;           ///< when a limit is exceeded first, from the start of the motion [s]
};

/// The worst value of one quantity along a verified motion.
struct Margin {
  Reason quantity = Reason::zmp;
  double value = 0.0;
  double limit = 0.0;
  double t = 0.0;     ///< when, from the start of the motion [s]
  std::string where;  ///< joint, link pair; may be empty
};

/// Proof that a motion was verified whole.
struct Certificate {
  std::vector<Margin> margins;
};

}  // namespace baton
