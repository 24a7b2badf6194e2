/// Where the robot is: the state that a motion begins or ends with.
#pragma once

#include <optional>
#include <string_view>

#include "baton/math/pose.hpp"
#include "baton/model/side.hpp"

namespace baton {

/// The five navigation points.
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
/// Side of a foot or hand.
[[nodiscard]] constexpr Side side_of(Part part) {
  return part == Part::left_foot || part == Part::left_hand ? Side::left : Side::right;
}
[[nodiscard]] constexpr Part foot(Side side) {
  return side == Side::left ? Part::left_foot : Part::right_foot;
}
[[nodiscard]] constexpr Part hand(Side side) {
  return side == Side::left ? Part::left_hand : Part::right_hand;
}

/// A foot on its way through the air, to land or to stay up.
struct Flight {
  Side side = Side::left;
  Pose from;          ///< where it left the ground
  double left = 0.0;  ///< time until it arrives [s]
  double rise = 0.0;  ///< time until it is highest; not positive: it has been [s]
  double apex = 0.0;  ///< how high that is [m]
};

/// A foot that is about to leave the ground: the weight is on its way to the other.
struct LiftOff {
  Side side = Side::left;
  double left = 0.0;  ///< time until then [s]
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
  BySide<bool> contact_before{true, true};            ///< which stood a moment before
  std::optional<LiftOff> lift_off;                    ///< of a foot that still stands
  std::optional<Flight> flight;                       ///< of the foot that does not stand

  /// Yaw of the heading frame: the mean of both soles' yaw [rad].
  [[nodiscard]] double heading() const { return mean_yaw(sole); }

  /// Mean height of the supporting soles [m].
  [[nodiscard]] double support_height() const {
    if (contact.left && contact.right) return 0.5 * (sole.left.p.z() + sole.right.p.z());
    return contact.left ? sole.left.p.z() : sole.right.p.z();
  }
};

}  // namespace baton
