/// A goal: one consistent set of subgoals for all navigation points, to be reached at rest.
#pragma once

#include <optional>

#include "baton/motion/posture.hpp"

namespace baton {

/// The kinds of segment (docs/theory.md §3).
enum class SegmentKind {
  shift,  ///< both feet stay: the COM, the trunk or a hand moves
  step,   ///< a foot leaves the ground and lands
  lift,   ///< a foot leaves the ground and stays up
  air,    ///< a lifted foot moves
  lower,  ///< a lifted foot lands
  reach,  ///< a hand is guided, both feet stay
};

inline constexpr std::size_t kSegmentKinds = static_cast<std::size_t>(SegmentKind::reach) + 1;

[[nodiscard]] constexpr std::string_view to_string(SegmentKind kind) {
  constexpr std::array<std::string_view, kSegmentKinds> names{"shift", "step", "lift", "air", "lower", "reach"};
  return names[static_cast<std::size_t>(kind)];
}

struct Goal {
  SegmentKind kind = SegmentKind::shift;
  Part guided = Part::trunk;
  std::optional<Side> swing;  ///< the foot that moves, if one does
  bool returns = false;       ///< it lands where it stood last
  double place_uncertainty =
      0.0;                  ///< how far off the place of the robot may be: edges are kept so much farther away [m]
  Pose drift_correction{};  ///< the part of it that makes up for soles that slid, a move of the planning frame
  BySide<Pose> sole;
  BySide<bool> contact{true, true};
  Vec3 com = Vec3::Zero();
  Mat3 trunk = Mat3::Identity();
  /// The guided hand's pose in the planning frame; other arms follow `arms`.
  BySide<std::optional<Pose>> hand;
  /// Angles of all joints of the model; only those of arms whose hand has no pose count [rad].
  VecX arms;
};

}  // namespace baton
