/// The reasons for refusing a command, in one table with their units and texts.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace baton {

enum class Reason {
  // about the goal: by guide and strategy; `sole_gap`, `ground` and `trunk_inclination` also along the motion
  foot_region,        ///< foothold outside the foot's reachable region
  foot_yaw,           ///< too much yaw between the soles
  sole_gap,           ///< soles closer than allowed
  ground,             ///< no known, flat terrain under the whole sole, away from edges
  com_height,         ///< COM at the end of its height range
  trunk_inclination,  ///< trunk tilted too far
  no_progress,        ///< no foothold leads closer to the goal; the cause is that of the preferred foothold
  no_landing,         ///< the lifted foot could not land from there; the cause says why
  no_history,         ///< nothing left to retrace
  inclined_sole,      ///< the sole that would have to carry alone is tilted, as on an edge
  // about the motion: by planner and verifier
  zmp,                 ///< ZMP too close to the edge of the support polygon
  unreachable,         ///< inverse kinematics leaves a residual above tolerance
  joint_limit,         ///< joint too close to a position limit
  joint_speed,         ///< joint speed above its limit
  joint_acceleration,  ///< joint acceleration above its limit
  joint_torque,        ///< share of the stall torque above its limit
  motor_heat,          ///< a winding too hot, on the way or at a rest that could not be left for a cooler one
  friction,            ///< ratio of tangential to normal contact force above its limit
  contact_wrench,      ///< contact wrench outside the contact-wrench cone, by a share of the weight
  self_collision,      ///< links too close to each other
  obstacle,            ///< link too close to something in the world
  swing_ground,        ///< swing sole would touch the terrain on its way
  not_finite,          ///< target or result not finite
};

inline constexpr std::size_t kReasons = static_cast<std::size_t>(Reason::not_finite) + 1;

/// Unit of a refusal's numbers.
enum class Unit {
  none,          ///< no numbers, or those of the cause
  length,        ///< [m]
  angle,         ///< [rad]
  speed,         ///< [rad/s]
  acceleration,  ///< [rad/s²]
  share,         ///< fraction of the stall torque, or of the permitted rise of temperature [-]
  number,        ///< ratio [-], or residual in m or rad
};

/// Kind of limit.
enum class Bound {
  none,
  at_least,
  at_most,
  range,  ///< from below and above; a refusal gives the nearer end
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
  std::string_view name;  ///< identifier in messages, plans and reports
  Unit unit;
  Bound bound;
  bool mends_with_time;   ///< a longer duration may help
  std::string_view text;  ///< for the operator; the page adds part and numbers
};

/// In the order of `Reason`. The page has a copy, web/src/reasons.json; docs/refusals.md explains each reason.
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
    {Reason::motor_heat, "motor_heat", Unit::share, Bound::at_most, false, "a motor would get too hot"},
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
