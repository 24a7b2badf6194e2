/// Result of planning: a verified motion with annotations, or a refusal.
#pragma once

#include <optional>
#include <variant>

#include "baton/verify/verified_motion.hpp"

namespace baton {

struct PlannedMotion {
  VerifiedMotion motion;
  int durations_tried = 0;  ///< by the duration correction
  /// Why the longest of the shorter durations tried was rejected.
  std::optional<Refusal> not_shorter{};
  /// Why the motion does only part of what the command asked for, if so.
  std::optional<Refusal> limit{};
};

using PlanResult = std::variant<PlannedMotion, Refusal>;

}  // namespace baton
