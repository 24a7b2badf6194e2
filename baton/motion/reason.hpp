/// Why a command can be refused: every reason, and what is known of it, in one table.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace baton {

enum class Reason {
  // guide: the goal itself
  foot_region,        ///< foothold outside the foot's reachable region
  foot_yaw,           ///< soles turned too far from each other
  sole_gap,           ///< soles closer than allowed
  ground,             ///< no known, flat ground under the whole sole, away from edges
  com_height,         ///< COM already at the end of its height range
  trunk_inclination,  ///< trunk tilted too far
  no_progress,        ///< no foothold brings the robot nearer to the goal; its cause is what speaks against the best
  no_landing,         ///< from there the lifted foot could not be put down again, for another cause
  no_history,         ///< nothing is left to retrace
  inclined_sole,      ///< the sole that would carry alone is inclined, as on an edge
  // plan and verify: the motion to it
  zmp,                 ///< ZMP nearer to the edge of the support polygon than the margin
  unreachable,         ///< inverse kinematics leaves a residual
  joint_limit,         ///< joint nearer to a position limit than the margin
  joint_speed,         ///< joint speed over its limit
  joint_acceleration,  ///< the same of its acceleration
  joint_torque,        ///< share of the stall torque over its limit
  friction,            ///< tangential over normal contact force
  contact_wrench,      ///< share of the weight that no forces at the soles' vertices give
  self_collision,      ///< links closer than allowed
  obstacle,            ///< link nearer to something in the world than allowed
  swing_ground,        ///< swing sole would touch the ground on its way
  not_finite,          ///< a target or a result is not a number
};

inline constexpr std::size_t kReasons = static_cast<std::size_t>(Reason::not_finite) + 1;

/// What a refusal's numbers are measured in.
enum class Unit {
  none,          ///< there are no numbers, or they are those of the cause
  length,        ///< [m]
  angle,         ///< [rad]
  speed,         ///< [rad/s]
  acceleration,  ///< [rad/s²]
  share,         ///< of what there is [-]
  number,        ///< a ratio [-], or a residual that may be in m or in rad
};

/// How a value is limited.
enum class Bound {
  none,
  at_least,
  at_most,
  range,  ///< from below and above: a refusal names the end that is nearer
};

[[nodiscard]] constexpr std::string_view to_string(Unit unit) {
  constexpr std::array<std::string_view, 7> names{"none",         "length", "angle", "speed",
                                                  "acceleration", "share",  "number"};
  return names[static_cast<std::size_t>(unit)];
}

[[nodiscard]] constexpr std::string_view to_string(Bound bound) {
  constexpr std::array<std::string_view, 4> names{"none", "at least", "at most", "range"};
  return names[static_cast<std::size_t>(bound)];
}

struct ReasonInfo {
  Reason reason;
  std::string_view name;  ///< in messages, plans and reports
  Unit unit;
  Bound bound;
  bool mends_with_time;   ///< a longer duration may mend it
  std::string_view text;  ///< for the operator; the page puts the part before it and the numbers behind it
};

/// In the order of `Reason`. The page's copy is web/src/reasons.json; docs/refusals.md explains every one.
inline constexpr std::array<ReasonInfo, kReasons> kReasonTable{{
    {Reason::foot_region, "foot_region", Unit::length, Bound::range, false, "the foothold would lie outside its reach"},
    {Reason::foot_yaw, "foot_yaw", Unit::angle, Bound::at_most, false,
     "the feet would be turned too far from each other"},
    {Reason::sole_gap, "sole_gap", Unit::length, Bound::at_least, false,
     "the soles would come too close to each other"},
    {Reason::ground, "ground", Unit::length, Bound::at_most, false, "there is no flat ground under the whole sole"},
    {Reason::com_height, "com_height", Unit::length, Bound::range, false, "the body is at the end of its height range"},
    {Reason::trunk_inclination, "trunk_inclination", Unit::angle, Bound::at_most, false,
     "the trunk would tilt too far"},
    {Reason::no_progress, "no_progress", Unit::none, Bound::none, false,
     "no foothold brings the robot nearer to the goal"},
    {Reason::no_landing, "no_landing", Unit::none, Bound::none, false,
     "the lifted foot could not be put down again from there"},
    {Reason::no_history, "no_history", Unit::none, Bound::none, false, "nothing left to retrace"},
    {Reason::inclined_sole, "inclined_sole", Unit::angle, Bound::at_most, false,
     "it stands tilted, as on an edge: it cannot carry the robot alone"},
    {Reason::zmp, "zmp", Unit::length, Bound::at_least, true,
     "the robot would be too close to tipping over an edge of its soles"},
    {Reason::unreachable, "unreachable", Unit::number, Bound::at_most, false,
     "arms and legs cannot reach that posture"},
    {Reason::joint_limit, "joint_limit", Unit::angle, Bound::at_least, false,
     "a joint would come too close to the end of its range"},
    {Reason::joint_speed, "joint_speed", Unit::speed, Bound::at_most, true, "a joint would have to turn too fast"},
    {Reason::joint_acceleration, "joint_acceleration", Unit::acceleration, Bound::at_most, true,
     "a joint would have to accelerate too fast"},
    {Reason::joint_torque, "joint_torque", Unit::share, Bound::at_most, true, "a motor would need too much torque"},
    {Reason::friction, "friction", Unit::number, Bound::at_most, true, "a foot would slip"},
    {Reason::contact_wrench, "contact_wrench", Unit::number, Bound::at_most, true,
     "the soles cannot provide the force and torque it takes"},
    {Reason::self_collision, "self_collision", Unit::length, Bound::at_least, false,
     "two links would come too close to each other"},
    {Reason::obstacle, "obstacle", Unit::length, Bound::at_least, false,
     "a link would come too close to something in the way"},
    {Reason::swing_ground, "swing_ground", Unit::length, Bound::at_least, false,
     "the foot would touch the ground on its way"},
    {Reason::not_finite, "not_finite", Unit::none, Bound::none, false, "the motion cannot be computed"},
}};

static_assert(
    [] {
      for (std::size_t i = 0; i < kReasons; ++i) {
        if (kReasonTable[i].reason != static_cast<Reason>(i)) return false;
      }
      return true;
    }(),
    "the table is in the order of Reason");

[[nodiscard]] constexpr const ReasonInfo& info(Reason reason) {
  return kReasonTable[static_cast<std::size_t>(reason)];
}
[[nodiscard]] constexpr std::string_view to_string(Reason reason) {
  return info(reason).name;
}
[[nodiscard]] constexpr bool mends_with_time(Reason reason) {
  return info(reason).mends_with_time;
}

}  // namespace baton
