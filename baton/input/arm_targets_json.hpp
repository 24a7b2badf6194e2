/// Targets for arms as JSON: in scripts, recordings and messages.
#pragma once

#include "baton/guide/arm_trajectory.hpp"
#include "baton/input/json_reader.hpp"

namespace baton {

/// Targets as JSON: `joints`, and, unless they are let go of, `at` and `q`, a list for each time.
[[nodiscard]] nlohmann::json to_json(const ArmTargets& targets);
/// @throws InputError it is none
[[nodiscard]] ArmTargets arm_targets_in(const JsonReader& read);

}  // namespace baton
