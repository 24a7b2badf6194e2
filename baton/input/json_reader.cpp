#include "baton/input/json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "baton/model/error.hpp"

namespace baton {
namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 32;

/// Nesting depth of brackets; only meaningful for valid JSON.
int depth(std::string_view text) {
  int deepest = 0, now = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') {
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == '[' || c == '{')) {
      deepest = std::max(deepest, ++now);
    } else if (!quoted && (c == ']' || c == '}')) {
      --now;
    }
  }
  return deepest;
}

}  // namespace

std::string shortened(std::string text, std::size_t longest) {
  if (text.size() <= longest) return text;
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U)
    --end;
  return text.substr(0, end) + "…";
}

std::string shown(const Json& value) {
  return shortened(value.dump(-1, ' ', true, Json::error_handler_t::replace), 80);
}

std::string reason(const Json::exception& error) {
  const std::string_view what = error.what();
  const std::size_t column = what.find("column ");
  return shortened(std::string(what.substr(column != std::string_view::npos ? column : what.find("] ") + 2)), 160);
}

Json parse_json(std::string_view text, const std::string& place) {
  if (depth(text) > kDeepest) throw InputError(fmt::format("{}: brackets nested too deeply", place));
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto check = [&](int /*depth*/, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
      throw InputError(fmt::format("{}: {} appears twice", place, shown(value)));
    return true;
  };
  try {
    return Json::parse(text.begin(), text.end(), check);
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: not JSON: {}", place, reason(error)));
  }
}

JsonReader JsonReader::at(const char* key) const {
  const std::string name = field_.empty() ? key : fmt::format("{}.{}", field_, key);
  if (!json_->is_object()) fail("an object with the key " + std::string(key));
  const auto found = json_->find(key);
  if (found == json_->end()) throw InputError(fmt::format("{}: {} is missing", place_, name));
  return {*found, place_, name};
}

JsonReader JsonReader::member(std::size_t i) const {
  return {(*json_)[i], place_, fmt::format("{}[{}]", field_, i)};
}

std::vector<JsonReader> JsonReader::list(std::optional<std::size_t> size) const {
  if (!json_->is_array() || json_->empty()) fail("a list that is not empty");
  if (size && json_->size() != *size) fail(fmt::format("a list of {}, not of {}", *size, json_->size()));
  std::vector<JsonReader> members;
  for (std::size_t i = 0; i < json_->size(); ++i)
    members.push_back(member(i));
  return members;
}

std::string JsonReader::text() const {
  if (!json_->is_string()) fail("a text");
  return json_->get<std::string>();
}

std::map<std::string, std::string> JsonReader::texts() const {
  if (!json_->is_object()) fail("an object of texts");
  std::map<std::string, std::string> all;
  for (const auto& [name, value] : json_->items())
    all[name] = at(name.c_str()).text();
  return all;
}

std::string JsonReader::one_of(std::initializer_list<std::string_view> words) const {
  std::string all;
  for (const std::string_view word : words) {
    if (*json_ == word) return std::string(word);
    all += fmt::format("{}{}", all.empty() ? "" : word == *(words.end() - 1) ? " or " : ", ", word);
  }
  fail(all);
}

bool JsonReader::boolean() const {
  if (!json_->is_boolean()) fail("true or false");
  return json_->get<bool>();
}

double JsonReader::number() const {
  if (!json_->is_number()) fail("a number");
  return json_->get<double>();
}

long JsonReader::integer(long least, long most) const {
  const auto wanted = [&] { return fmt::format("a whole number from {} to {}", least, most); };
  if (!json_->is_number_integer()) fail(wanted());
  // Unsigned values beyond the signed range would turn negative.
  const bool huge = json_->is_number_unsigned() && json_->get<std::uint64_t>() > std::numeric_limits<long>::max();
  if (huge || json_->get<long>() < least || json_->get<long>() > most) fail(wanted());
  return json_->get<long>();
}

VecX JsonReader::vector(Eigen::Index size, bool nulls) const {
  if (!json_->is_array()) fail(fmt::format("a list of {} numbers", size));
  if (static_cast<Eigen::Index>(json_->size()) != size) {
    throw InputError(
        fmt::format("{}: {} has {} members: must be a list of {} numbers", place_, field_, json_->size(), size));
  }
  VecX v(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Json& value = (*json_)[static_cast<std::size_t>(i)];
    const bool null = nulls && value.is_null();
    v[i] = null                ? std::numeric_limits<double>::quiet_NaN()
           : value.is_number() ? value.get<double>()
                               : member(static_cast<std::size_t>(i)).number();
  }
  return v;
}

void JsonReader::fail(const std::string& wanted) const {
  throw InputError(
      fmt::format("{}: {}{}: must be {}", place_, field_.empty() ? "" : field_ + " = ", shown(*json_), wanted));
}

}  // namespace baton
