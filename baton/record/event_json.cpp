#include "baton/record/event_json.hpp"

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "baton/record/json.hpp"
#include "baton/record/plan_json.hpp"
#include "baton/record/recording_channels.hpp"

namespace baton {
namespace {

using Json = nlohmann::json;

std::string_view intent_name(const Intent& intent) {
  constexpr std::array<std::string_view, std::variant_size_v<Intent>> names{"follow", "retrace", "home", "stop",
                                                                            "halt",   "catch",   "cool", "arms"};
  return names[intent.index()];
}

/// All numbers of it rounded to 1e-6.
Json rounded_json(Json json) {
  if (json.is_number_float()) return std::round(1e6 * json.get<double>()) / 1e6;
  if (json.is_structured()) {
    for (Json& member : json)
      member = rounded_json(std::move(member));
  }
  return json;
}

/// A motion without what can be planned again from it: phases, knots, margins.
Json motion_json(const PlannedMotion& planned, const Pose& anchor) {
  Json json = to_json(planned, anchor);
  for (const char* key : {"phases", "knots", "margins"})
    json.erase(key);
  return rounded_json(std::move(json));
}

struct EventMessage {
  const Navigator& navigator;

  Json operator()(const Committed& e) const { return {{"event", "committed"}, {"segment", e.segment}}; }
  Json operator()(const Ended& /*e*/) const { return {{"event", "ended"}}; }
  Json operator()(const Refused& e) const {
    Json json = {{"event", "refused"}, {"again", e.again}};
    if (navigator.refusal() != nullptr) json.update(to_json(*navigator.refusal()));
    return json;
  }
  Json operator()(const AnswerLate& /*e*/) const { return {{"event", "answer_late"}}; }
  Json operator()(const Slipped& e) const { return {{"event", "slipped"}, {"distance", e.distance}}; }
  Json operator()(const DisturbedChanged& e) const { return {{"event", "disturbed"}, {"disturbed", e.disturbed}}; }
  Json operator()(const GuardChanged& e) const {
    return {{"event", "guard"}, {"from", to_string(e.from)}, {"to", to_string(e.to)}};
  }
  Json operator()(const SensorChanged& e) const {
    return {{"event", "sensor"}, {"sensor", to_string(e.sensor)}, {"health", to_string(e.health)}};
  }
  Json operator()(const ArmsRefused& /*e*/) const {
    Json json = {{"event", "arms_refused"}};
    if (navigator.arms_refusal() != nullptr) json.update(to_json(*navigator.arms_refusal()));
    return json;
  }
  Json operator()(const HeatChanged& e) const { return {{"event", "heat"}, {"hot", e.hot}}; }
};

}  // namespace

std::vector<Json> event_messages(const Navigator& navigator) {
  std::vector<Json> messages;
  for (const Event& event : navigator.events())
    messages.push_back(std::visit(EventMessage{navigator}, event));
  return messages;
}

Json segment_message(const Navigator& navigator) {
  const PlannedMotion* planned = navigator.planned();
  Json json = planned != nullptr ? motion_json(*planned, navigator.anchor()) : Json::object();
  json["segment"] = navigator.segment();
  json["purpose"] = to_string(navigator.purpose());
  return json;
}

Json offer_message(const PlanRecord& record) {
  Json intents = Json::array();
  for (const Intent& intent : record.request.intents)
    intents.push_back(intent_name(intent));
  const Answer& answer = record.answer;
  Json json = {{"call", "offer"},
               {"at", answer.at},
               {"command", to_json(record.request.command)},
               {"intents", std::move(intents)},
               {"intent", intent_name(answer.intent)},
               {"outcome", "nothing"}};
  if (const PlannedMotion* planned = answer.planned()) {
    json["outcome"] = "motion";
    json["motion"] = {{"kind", to_string(planned->motion->goal.kind)},
                      {"guided", to_string(planned->motion->goal.guided)},
                      {"T", planned->motion->duration()},
                      {"durations_tried", planned->durations_tried},
                      {"limit", to_json(planned->limit)}};
  } else if (const Refusal* refusal = answer.refusal()) {
    json["outcome"] = "refusal";
    json["refusal"] = to_json(*refusal);
  }
  return json;
}

Json to_json(const Command& command) {
  return {{"guide", to_string(command.guide)},
          {"axes", vector_json(command.axes)},
          {"lift", {command.lift.left, command.lift.right}},
          {"recall", kRecalls[static_cast<std::size_t>(command.recall)]}};
}

}  // namespace baton
