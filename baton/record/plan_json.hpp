/// Motions and refusals as JSON, for `baton plan` (docs/plan.md).
#pragma once

#include <nlohmann/json.hpp>

#include "baton/plan/planned_motion.hpp"

namespace baton {

/// Lengths in m, angles in rad, times in s; `anchor` transforms poses into the world frame.
[[nodiscard]] nlohmann::json to_json(const PlannedMotion& planned, const Pose& anchor);

[[nodiscard]] nlohmann::json to_json(const Refusal& refusal);
/// No refusal becomes null.
[[nodiscard]] nlohmann::json to_json(const std::optional<Refusal>& refusal);

/// The worst value of each quantity.
[[nodiscard]] nlohmann::json to_json(const Certificate& certificate);

}  // namespace baton
