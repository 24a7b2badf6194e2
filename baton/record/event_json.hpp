/// What happens in a run, as the messages of a recording.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "baton/navigate/navigator.hpp"
#include "baton/run/sink.hpp"

namespace baton {

/// The events of the latest tick, in order.
[[nodiscard]] std::vector<nlohmann::json> event_messages(const Navigator& navigator);

/// The motion that was committed in the latest tick.
[[nodiscard]] nlohmann::json segment_message(const Navigator& navigator);

/// A request and its answer.
[[nodiscard]] nlohmann::json offer_message(const PlanRecord& record);

[[nodiscard]] nlohmann::json to_json(const Command& command);

}  // namespace baton
