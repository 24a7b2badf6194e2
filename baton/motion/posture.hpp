/// Postures: the planned state that a motion begins or ends with.
#pragma once

#include <optional>
#include <string_view>

#include "baton/math/pose.hpp"
#include "baton/model/heat.hpp"
#include "baton/model/side.hpp"

namespace baton {

/// The body parts that can be guided: the five navigation points.
enum class Part { left_foot, right_foot, left_hand, right_hand, trunk };

inline constexpr std::array<Part, 5> kParts{Part::left_foot, Part::right_foot, Part::left_hand, Part::right_hand,
                                            Part::trunk};

[[nodiscard]] constexpr std::string_view to_string(Part part) {
  constexpr std::array<std::string_view, 5> names{"left_foot", "right_foot", "left_hand", "right_hand", "trunk"};
  return names[static_cast<std::size_t>(part)];
}

[[nodiscard]] constexpr bool is_foot(Part part) {
  return part == Part::left_foot || part == Part::right_foot;
}
[[nodiscard]] constexpr bool is_hand(Part part) {
  return part == Part::left_hand || part == Part::right_hand;
}
/// Side of a foot or hand; right for the trunk.
[[nodiscard]] constexpr Side side_of(Part part) {
  return part == Part::left_foot || part == Part::left_hand ? Side::left : Side::right;
}
[[nodiscard]] constexpr Part foot(Side side) {
  return side == Side::left ? Part::left_foot : Part::right_foot;
}
[[nodiscard]] constexpr Part hand(Side side) {
  return side == Side::left ? Part::left_hand : Part::right_hand;
}

/// A swing in progress, to land or to stay in the air.
struct Flight {
  Side side = Side::left;
  Pose from;               ///< pose at lift-off
  double remaining = 0.0;  ///< time until it arrives [s]
  double to_apex = 0.0;    ///< time until the apex; zero or negative once past it [s]
  double apex = 0.0;       ///< height of the apex [m]
};

/// A foot about to lift off, while the weight shifts to the other.
struct LiftOff {
  Side side = Side::left;
  double remaining = 0.0;  ///< time until lift-off [s]
};

/// Planned state of the whole robot, in the planning frame.
struct Posture {
  VecX q;                     ///< configuration (nq)
  VecX dq;                    ///< its velocity (nv)
  VecX ddq;                   ///< its acceleration (nv)
  Vec3 com = Vec3::Zero();    ///< [m]
  Vec3 dcom = Vec3::Zero();   ///< [m/s]
  Vec3 ddcom = Vec3::Zero();  ///< [m/s²]
  Mat3 trunk = Mat3::Identity();
  BySide<Pose> sole;
  BySide<Pose> hand;
  BySide<Vec3> shoulder{Vec3::Zero(), Vec3::Zero()};  ///< [m]
  BySide<bool> contact{true, true};                   ///< which soles stand
  BySide<bool> contact_before{true, true};            ///< contacts just before
  std::optional<LiftOff> lift_off;                    ///< of a foot still in contact
  std::optional<Flight> flight;                       ///< of the foot in the air
  Heat heat;                                          ///< of the motors; empty: cold

  /// Yaw of the heading frame: mean yaw of the soles [rad].
  [[nodiscard]] double heading() const { return mean_yaw(sole); }

  /// Mean height of the soles in contact [m].
  [[nodiscard]] double support_height() const {
    if (contact.left && contact.right) return 0.5 * (sole.left.p.z() + sole.right.p.z());
    return contact.left ? sole.left.p.z() : sole.right.p.z();
  }
};

}  // namespace baton
