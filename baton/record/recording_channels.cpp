#include "baton/record/recording_channels.hpp"

#include "baton/record/ros_messages.hpp"

namespace baton {
namespace {

/// Schemas of the messages in JSON. Times are those of the messages, ticks their sequence numbers.
constexpr std::string_view json_schema(Topic topic) {
  switch (topic) {
    case Topic::tick:
      return R"({"title": "baton.Tick", "type": "object", "required": ["age", "sum"], "properties": {
"age": {"type": ["number", "null"], "description": "age of the measurement [s]"},
"sum": {"type": "string", "description": "FNV-1a, 64 bits, of the whole joint target"},
"attitude": {"type": "array", "items": {"type": "integer"}, "minItems": 9, "maxItems": 9, "description":
"bits of the measured attitude matrix (by columns), less those of the matrix of /imu's quaternion; left out: 0"}}})";
    case Topic::command:
      return R"({"title": "baton.Command", "type": "object", "required": ["guide", "axes", "lift", "recall"], "properties": {
"guide": {"type": "string", "enum": ["left_foot", "right_foot", "left_hand", "right_hand", "trunk"]},
"axes": {"type": "array", "items": {"type": "number"}, "minItems": 6, "maxItems": 6},
"lift": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2, "description": "left, right foot"},
"recall": {"type": "string", "enum": ["none", "retrace", "home", "stop"]}}})";
    case Topic::planner:
      return R"({"title": "baton.Planner", "type": "object", "required": ["call"], "properties": {
"call": {"type": "string", "enum": ["ask", "offer"], "description": "a request was issued; its answer arrived"},
"at": {"type": "integer", "description": "tick of the take-over"},
"command": {"type": "object", "description": "that the request is for"},
"intents": {"type": "array", "items": {"type": "string"}, "description": "tried in this order; none: the command's"},
"intent": {"type": "string", "description": "of the answer"},
"outcome": {"type": "string", "enum": ["nothing", "motion", "refusal"]},
"motion": {"type": "object"}, "refusal": {"type": "object"}}})";
    case Topic::root:
      return R"({"title": "baton.Root", "type": "object", "required": ["position", "attitude", "velocity", "rate"], "properties": {
"position": {"type": "array", "description": "of the root, as measured by a simulator [m]"},
"attitude": {"type": "array", "description": "matrix by columns"},
"velocity": {"type": "array", "description": "in the world [m/s]"},
"rate": {"type": "array", "description": "in the root's frame [rad/s]"}}})";
    case Topic::arms:
      return R"({"title": "baton.ArmTargets", "type": "object", "required": ["joints"], "properties": {
"joints": {"type": "array", "items": {"type": "string"}},
"at": {"type": "array", "items": {"type": "number"}, "description": "times [s]; left out: the joints are let go of"},
"q": {"type": "array", "items": {"type": "array"}, "description": "for each time, an angle of each joint [rad]"}}})";
    case Topic::events:
      return R"({"title": "baton.Event", "type": "object", "required": ["event"], "properties": {
"event": {"type": "string", "enum": ["committed", "ended", "refused", "answer_late", "slipped", "disturbed", "guard",
"sensor", "heat", "arms_refused"]},
"segment": {"type": "integer"}, "again": {"type": "boolean"}, "distance": {"type": "number", "description": "[m]"},
"disturbed": {"type": "boolean"}, "hot": {"type": "boolean"}, "from": {"type": "string"}, "to": {"type": "string"},
"sensor": {"type": "string"}, "health": {"type": "string", "enum": ["good", "bridged", "lost"]},
"reason": {"type": "string"}, "part": {"type": "string"}, "value": {"type": ["number", "null"]},
"limit": {"type": ["number", "null"]}, "where": {"type": "string"}}})";
    case Topic::segments:
      return R"({"title": "baton.Segment", "type": "object", "required": ["segment", "purpose", "kind", "guided", "T"], "properties": {
"segment": {"type": "integer", "description": "its number, from 0"},
"purpose": {"type": "string"}, "kind": {"type": "string"}, "guided": {"type": "string"},
"swing": {"type": ["string", "null"]}, "T": {"type": "number", "description": "duration [s]"},
"retraces": {"type": "boolean"}, "durations_tried": {"type": "integer"},
"not_shorter": {"type": ["object", "null"], "description": "why a shorter duration was rejected"},
"limit": {"type": ["object", "null"], "description": "why it does only part of what the command asked for"},
"goal": {"type": "object", "description": "poses at its end, in the world, rounded to 1e-6 [m, rad]"}}})";
    case Topic::estimates:
      return R"({"title": "baton.Estimates", "type": "object", "properties": {
"com": {"type": "array", "description": "in the world, as all of these, rounded to 10 um [m]"},
"zmp_plan": {"type": "array", "description": "[m]"},
"zmp": {"type": "array", "description": "commanded by the stabiliser [m]"},
"dcm_error": {"type": "array", "description": "measured less planned [m]"},
"phase": {"type": "string", "enum": ["hold", "double", "single_left", "single_right", "fallen"]},
"guard": {"type": "string"}, "segment": {"type": "integer"},
"heat": {"type": "number", "description": "of the hottest motor [permitted rise]"}}})";
    case Topic::pushes:
      return R"({"title": "baton.Push", "type": "object", "required": ["impulse", "duration", "on"], "properties": {
"impulse": {"type": "array", "description": "in the world [N s]"},
"duration": {"type": "number", "description": "[s]"},
"on": {"type": "string", "enum": ["trunk", "left_hand", "right_hand"]}}})";
    case Topic::link:
      return R"({"title": "baton.Link", "type": "object", "required": ["what", "text"], "properties": {
"what": {"type": "string", "enum": ["late", "in_time", "fault", "fault_over", "battery", "rejected", "damped", "broken", "log"]},
"text": {"type": "string"}}})";
    case Topic::falls:
      return R"({"title": "baton.Fall", "type": "object", "required": ["fall"], "properties": {
"fall": {"type": "string", "description": "by what the simulator saw it"}}})";
    default:
      return "{}";
  }
}

}  // namespace

mcap::Schema schema_of(Topic topic) {
  const TopicInfo& about = info(topic);
  if (about.ros) return ros::schema(std::string(about.schema));
  return {std::string(about.schema), "jsonschema", std::string(json_schema(topic))};
}

std::optional<Topic> topic_of(const mcap::Channel& channel, const mcap::Schema* schema) {
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    const TopicInfo& about = kTopics[i];
    if (channel.topic != about.topic || channel.encoding != (about.ros ? "cdr" : "json")) continue;
    if (schema != nullptr && schema->name == about.schema) return static_cast<Topic>(i);
  }
  return std::nullopt;
}

}  // namespace baton
