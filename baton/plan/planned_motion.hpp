/// What planning answers: a verified motion with what is known beside it, or a refusal.
#pragma once

#include <optional>
#include <variant>

#include "baton/verify/verified_motion.hpp"

namespace baton {

struct PlannedMotion {
  VerifiedMotion motion;
  int durations_tried = 0;  ///< by the duration correction
  /// What spoke against the longest of the shorter durations that were tried.
  std::optional<Refusal> not_shorter{};
  /// What spoke against all that the command asked for, if the motion does only a part of it.
  std::optional<Refusal> limit{};
};

using PlanResult = std::variant<PlannedMotion, Refusal>;

}  // namespace baton
