/// A goal: consistent target poses of all body parts, to be reached at rest.
#pragma once

#include <memory>
#include <optional>

#include "baton/motion/arm_path.hpp"
#include "baton/motion/posture.hpp"

namespace baton {

/// The kinds of segment (docs/theory.md §3).
enum class SegmentKind {
  shift,  ///< both feet stay; COM, trunk or arms move
  step,   ///< a foot takes off and lands
  lift,   ///< a foot takes off and stays in the air
  air,    ///< a foot moves in the air
  lower,  ///< a foot in the air lands
  reach,  ///< both feet stay; a hand is guided
  arms,   ///< nothing moves but the arms, by targets from outside
};

inline constexpr std::size_t kSegmentKinds = static_cast<std::size_t>(SegmentKind::arms) + 1;

[[nodiscard]] constexpr std::string_view to_string(SegmentKind kind) {
  constexpr std::array<std::string_view, kSegmentKinds> names{"shift", "step", "lift", "air", "lower", "reach", "arms"};
  return names[static_cast<std::size_t>(kind)];
}

/// Poses are in the planning frame.
struct Goal {
  SegmentKind kind = SegmentKind::shift;
  Part guided = Part::trunk;
  std::optional<Side> swing;       ///< the foot that moves, if any
  bool returns = false;            ///< the swing foot lands on its previous foothold
  double place_uncertainty = 0.0;  ///< error bound of the robot's position [m]
  Pose drift_correction{};         ///< what the goal moves beyond what was asked for: corrects drift, or leaves some
  BySide<Pose> sole;
  BySide<bool> contact{true, true};  ///< which soles stand at the end
  Vec3 com = Vec3::Zero();           ///< [m]
  Mat3 trunk = Mat3::Identity();
  /// Pose of the guided hand. An arm without one follows `arms`.
  BySide<std::optional<Pose>> hand;
  /// Joint angles (n); only those of arms whose hand has no pose are used [rad].
  VecX arms;
  /// Of joints that are driven from outside; they do not follow `arms`. Null: there are none.
  std::shared_ptr<const ArmPath> arm_path{};
  /// First duration that is tried, if no foot takes off or lands; none: the profile's [s].
  std::optional<double> duration{};
};

}  // namespace baton
