#include "baton/cockpit/protocol.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace baton {
namespace {

using nlohmann::json;

/// Rounded to five decimals, enough for drawing, to keep messages short. NaN becomes null.
json number(double value) {
  return std::isfinite(value) ? json(std::round(value * 1e5) / 1e5) : json(nullptr);
}

template <typename Vector>
json numbers(const Vector& values) {
  json list = json::array();
  for (const double value : values)
    list.push_back(number(value));
  return list;
}

json by_side(const BySide<bool>& value) {
  return {value.left, value.right};
}

json pose(const Pose& pose) {
  json list = numbers(pose.p);
  const Eigen::Quaterniond q(pose.R);
  for (const double value : {q.w(), q.x(), q.y(), q.z()})
    list.push_back(number(value));
  return list;
}

json goal(const Goal& goal, const RobotModel& robot) {
  json soles = json::array();
  json hands = json::array();
  for (const Side side : kSides) {
    json corners = json::array();
    for (const Vec2& corner : robot.sole(side).vertices()) {
      corners.push_back(numbers(goal.sole[side] * Vec3(corner.x(), corner.y(), 0.0)));
    }
    soles.push_back(std::move(corners));
    hands.push_back(goal.hand[side] ? pose(*goal.hand[side]) : json(nullptr));
  }
  return {{"kind", to_string(goal.kind)},
          {"guided", to_string(goal.guided)},
          {"swing", goal.swing ? json(*goal.swing == Side::left ? "left" : "right") : json(nullptr)},
          {"soles", soles},
          {"hands", hands},
          {"com", numbers(goal.com)}};
}

json refusal(const Refusal& refusal) {
  return {{"reason", to_string(refusal.reason)},
          {"part", to_string(refusal.part)},
          {"value", number(refusal.value)},
          {"limit", number(refusal.limit)},
          {"where", refusal.where},
          {"cause", refusal.cause ? json(to_string(*refusal.cause)) : json(nullptr)}};
}

json stuck(const Stuck& stuck) {
  return {{"part", to_string(stuck.part)}, {"times", stuck.times}, {"retrace", stuck.retrace}, {"home", stuck.home}};
}

std::optional<Recall> recall_named(std::string_view name) {
  const auto* found = std::find(kRecalls.begin(), kRecalls.end(), name);
  if (found == kRecalls.end()) return std::nullopt;
  return static_cast<Recall>(found - kRecalls.begin());
}

std::optional<Part> part_named(std::string_view name) {
  const auto* found = std::find_if(kParts.begin(), kParts.end(), [name](Part part) { return to_string(part) == name; });
  return found == kParts.end() ? std::nullopt : std::optional<Part>(*found);
}

/// Reads a list of `count` numbers, null as NaN. False for anything else.
template <typename Out>
bool read_numbers(const json& message, const char* key, std::size_t count, Out&& out) {
  const auto found = message.find(key);
  if (found == message.end() || !found->is_array() || found->size() != count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const json& value = (*found)[i];
    if (!value.is_number() && !value.is_null()) return false;
    out(i) = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  }
  return true;
}

PageMessage parse_command(const json& message) {
  Steer steer;
  const auto guide = message.find("guide");
  const auto deadman = message.find("deadman");
  if (guide == message.end() || !guide->is_string()) return Malformed{"command: guide is not a string"};
  const std::optional<Part> part = part_named(guide->get_ref<const std::string&>());
  if (!part) return Malformed{"command: guide is not the name of a part"};
  steer.command.guide = *part;
  const auto axis = [&](std::size_t i) -> double& { return steer.command.axes[static_cast<Eigen::Index>(i)]; };
  const auto lift = [&](std::size_t i) -> double& { return steer.command.lift[kSides.at(i)]; };
  if (!read_numbers(message, "axes", 6, axis)) return Malformed{"command: axes are not 6 numbers"};
  if (!read_numbers(message, "lift", 2, lift)) return Malformed{"command: lift is not 2 numbers"};
  const auto recalled = message.find("recall");
  if (recalled == message.end() || !recalled->is_string()) return Malformed{"command: recall is not a string"};
  const std::optional<Recall> recall = recall_named(recalled->get_ref<const std::string&>());
  if (!recall) return Malformed{"command: recall is not none, retrace, home or stop"};
  steer.command.recall = *recall;
  if (deadman == message.end() || !deadman->is_boolean()) return Malformed{"command: deadman is not true or false"};
  steer.deadman = deadman->get<bool>();
  return steer;
}

}  // namespace

PageMessage parse_page_message(std::string_view text) {
  if (text.size() > kLargestMessage) return Malformed{"the message is too long"};
  const json message = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return Malformed{"not a JSON object"};
  const auto type = message.find("type");
  if (type == message.end() || !type->is_string()) return Malformed{"the message has no type"};
  const std::string& name = type->get_ref<const std::string&>();
  if (name == "drive") return TakeSeat{};
  if (name == "release") return LeaveSeat{};
  if (name == "damp") return AskDamp{};
  if (name == "command") return parse_command(message);
  return Malformed{"unknown type of message"};
}

std::string state_message(const Frame& frame, const DeviceStatus& device, const RobotModel& robot, Role role,
                          bool taken) {
  json bodies = json::array();
  for (const Pose& body : frame.bodies)
    bodies.push_back(pose(body));
  json support = json::array();
  for (const Vec2& vertex : frame.balance.support.vertices())
    support.push_back(numbers(vertex));
  const json message{
      {"type", "state"},
      {"role", role == Role::driver ? "driver" : "watcher"},
      {"taken", taken},
      {"state", to_string(frame.activity)},
      {"t", number(frame.t)},
      {"bodies", bodies},
      {"guide", to_string(frame.command.guide)},
      {"axes", numbers(frame.command.axes)},
      {"lift", {number(frame.command.lift.left), number(frame.command.lift.right)}},
      {"recall", kRecalls.at(static_cast<std::size_t>(frame.command.recall))},
      {"device",
       {{"name", device.name}, {"connected", device.connected}, {"armed", device.armed}, {"hint", device.hint}}},
      {"goal", frame.segment.goal ? goal(*frame.segment.goal, robot) : json(nullptr)},
      {"segment", {{"time", number(frame.segment.time)}, {"duration", number(frame.segment.duration)}}},
      {"contact", by_side(frame.balance.contact)},
      {"support", support},
      {"support_height", number(frame.balance.support_height)},
      {"com", numbers(frame.balance.com)},
      {"zmp", numbers(frame.balance.zmp)},
      {"dcm", numbers(frame.balance.dcm)},
      {"refusal", frame.refusal ? refusal(*frame.refusal) : json(nullptr)},
      {"refusals", frame.refusals},
      {"stuck", frame.stuck ? stuck(*frame.stuck) : json(nullptr)},
      {"limit", frame.segment.limit ? refusal(*frame.segment.limit) : json(nullptr)},
      {"history", frame.history},
      {"damps", frame.damps},
      {"message", frame.message}};
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string error_message(std::string_view text) {
  return json{{"type", "error"}, {"text", text}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace baton
