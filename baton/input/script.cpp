#include "baton/input/script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"

namespace baton {
namespace {

using Json = nlohmann::json;

constexpr double kSameTime = 1e-9;   // [s] tolerance for floating-point tick times
constexpr double kLatest = 86400.0;  // [s] a day
constexpr std::array<std::string_view, 7> kKeys{"t", "guide", "axes", "lift", "retrace", "home", "stop"};

/// Reads one line; each error names file, line, key, value and what is expected.
class Line {
 public:
  Line(std::string_view text, std::string place) : place_(std::move(place)) {
    constexpr int kDeepestLine = 4;
    std::set<std::string> keys;
    const auto check = [&](int depth, Json::parse_event_t event, Json& value) {
      if (depth > kDeepestLine) throw InputError(fmt::format("{}: brackets nested too deeply", place_));
      if (depth == 1 && event == Json::parse_event_t::key && !keys.insert(value.get<std::string>()).second) {
        throw InputError(fmt::format("{}: {} appears twice", place_, shown(value)));
      }
      return true;
    };
    try {
      json_ = Json::parse(text.begin(), text.end(), check);
    } catch (const Json::exception& error) {
      throw InputError(fmt::format("{}: not JSON: {}", place_, reason(error)));
    }
    if (!json_.is_object()) {
      throw InputError(fmt::format("{}: {}: must be an object like {{\"t\": 0.5, \"axes\": [1, 0, 0, 0, 0, 0]}}",
                                   place_, shown(json_)));
    }
    for (const auto& [key, value] : json_.items()) {
      if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end()) {
        throw InputError(fmt::format("{}: unknown key {}: must be t, guide, axes, lift, retrace, home or stop", place_,
                                     shown(Json(key))));
      }
    }
  }

  [[nodiscard]] double time(double earliest) const {
    if (!json_.contains("t")) throw InputError(fmt::format("{}: t is missing: must be a time in seconds", place_));
    const Json& value = json_["t"];
    if (!value.is_number() || value.get<double>() < 0.0) fail("t", "a time in seconds, 0 or more");
    const auto t = value.get<double>();
    if (t < earliest) fail("t", fmt::format("at least {}, the time of the line before", earliest));
    if (t > kLatest) fail("t", fmt::format("at most {:.0f} s, a day", kLatest));
    return t;
  }

  [[nodiscard]] Part guide(Part before) const {
    if (!json_.contains("guide")) return before;
    for (const Part part : kParts) {
      if (json_["guide"] == to_string(part)) return part;
    }
    fail("guide", "left_foot, right_foot, left_hand, right_hand or trunk");
  }

  [[nodiscard]] Vec6 axes() const {
    if (!json_.contains("axes")) return Vec6::Zero();
    const auto values = numbers<6>("axes", "6 numbers or nulls: [x, y, z, roll, pitch, yaw]");
    return Eigen::Map<const Vec6>(values.data());
  }

  [[nodiscard]] BySide<double> lift(const BySide<double>& before) const {
    if (!json_.contains("lift")) return before;
    const auto [left, right] = numbers<2>("lift", "2 numbers or nulls: [left, right]");
    return {left, right};
  }

  [[nodiscard]] Recall recall() const {
    std::optional<std::string_view> pressed;
    for (const char* button : {"retrace", "home", "stop"}) {
      if (!held(button)) continue;
      if (pressed)
        throw InputError(fmt::format("{}: {} and {} are both true: must be one at a time", place_, *pressed, button));
      pressed = button;
    }
    return recall_of(pressed == "stop", pressed == "retrace", pressed == "home");
  }

 private:
  [[nodiscard]] bool held(const char* key) const {
    if (!json_.contains(key)) return false;
    if (!json_[key].is_boolean()) fail(key, "true or false");
    return json_[key].get<bool>();
  }

  template <std::size_t N>
  [[nodiscard]] std::array<double, N> numbers(const char* key, const char* wanted) const {
    const Json& list = json_[key];
    if (!list.is_array() || list.size() != N) fail(key, wanted);
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) {
      if (!list[i].is_number() && !list[i].is_null()) fail(key, wanted);
      values[i] = list[i].is_null() ? std::numeric_limits<double>::quiet_NaN() : list[i].get<double>();
    }
    return values;
  }

  [[noreturn]] void fail(const char* key, std::string_view wanted) const {
    throw InputError(fmt::format("{}: {} = {}: must be {}", place_, key, shown(json_[key]), wanted));
  }

  std::string place_;
  Json json_;
};

bool blank(std::string_view line) {
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

}  // namespace

Script Script::load(const std::filesystem::path& file) {
  return parse(read_input(file, "script"), file.string());
}

Script Script::load(const std::filesystem::path& file, const std::atomic<bool>& stop) {
  return parse(read_input(file, "script", stop), file.string());
}

Script Script::parse(std::string_view text, std::string name) {
  std::vector<Entry> entries;
  Entry before;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    const std::string_view content = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    if (blank(content)) continue;
    const Line line(content, fmt::format("script {}: line {}", name, number));
    Entry entry{line.time(before.t), {line.guide(before.command.guide), line.axes(), {}, {}}};
    entry.command.lift = line.lift(before.command.lift);
    entry.command.recall = line.recall();
    before = entry;
    entries.push_back(entry);
  }
  if (entries.empty()) {
    throw InputError(fmt::format("script {}: empty: must hold a line like {{\"t\": 0}}", name));
  }
  return Script(std::move(entries), std::move(name));
}

Script::Script(std::vector<Entry> entries, std::string name) : entries_(std::move(entries)), name_(std::move(name)) {
  double earliest = 0.0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    auto& [t, command] = entries_[i];
    if (!(t >= earliest && std::isfinite(t))) {
      throw InputError(
          fmt::format("script {}: entry {}: t = {}: must be finite and at least {}", name_, i, t, earliest));
    }
    earliest = t;
    for (double& axis : command.axes)
      axis = std::clamp(axis, -1.0, 1.0);
    for (const Side side : kSides)
      command.lift[side] = std::clamp(command.lift[side], 0.0, 1.0);
  }
}

Command Script::read(double t) {
  const auto next = std::partition_point(entries_.begin(), entries_.end(),
                                         [t](const Entry& entry) { return entry.t <= t + kSameTime; });
  return next == entries_.begin() ? Command{} : std::prev(next)->command;
}

DeviceStatus Script::status() const {
  return {.name = name_, .connected = true, .armed = true, .hint = ""};
}

std::string script_line(double t, const Command& command) {
  const auto number = [](double value) -> std::string {
    if (std::isnan(value)) return "null";
    if (std::isinf(value)) return value > 0.0 ? "1e308" : "-1e308";
    return value == 0.0 && std::signbit(value) ? "-0.0" : fmt::format("{}", value);
  };
  std::string axes;
  for (const double axis : command.axes)
    axes += (axes.empty() ? "" : ", ") + number(axis);
  const char* recall = command.recall == Recall::retrace ? R"(, "retrace": true)"
                       : command.recall == Recall::home  ? R"(, "home": true)"
                       : command.recall == Recall::stop  ? R"(, "stop": true)"
                                                         : "";
  return fmt::format(R"({{"t": {}, "guide": "{}", "axes": [{}], "lift": [{}, {}]{}}})", number(t),
                     to_string(command.guide), axes, number(command.lift.left), number(command.lift.right), recall);
}

}  // namespace baton
