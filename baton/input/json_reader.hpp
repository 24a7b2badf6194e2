/// Validating reader for untrusted JSON: each error is one line naming place, field, value and what is expected.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// Truncates at a UTF-8 character boundary to fit a message.
[[nodiscard]] std::string shortened(std::string text, std::size_t longest);

/// A value as JSON text, truncated to fit a message.
[[nodiscard]] std::string shown(const nlohmann::json& value);

/// The parser's message without exception class and line number (always 1).
[[nodiscard]] std::string reason(const nlohmann::json::exception& error);

/// @param place file, and line if there are several; prefix of every message
/// @throws InputError not JSON, or nested more than 32 levels deep
[[nodiscard]] nlohmann::json parse_json(std::string_view text, const std::string& place);

/// A value and its location. All members throw InputError if the value is not of the requested kind.
class JsonReader {
 public:
  /// @param json must outlive this object
  JsonReader(const nlohmann::json& json, std::string place, std::string field = "")
      : json_(&json), place_(std::move(place)), field_(std::move(field)) {}

  [[nodiscard]] bool has(const char* key) const { return json_->is_object() && json_->contains(key); }
  /// @throws InputError also if missing
  [[nodiscard]] JsonReader at(const char* key) const;
  /// The elements of an array.
  /// @param size required size; none: any but 0
  [[nodiscard]] std::vector<JsonReader> list(std::optional<std::size_t> size = std::nullopt) const;
  [[nodiscard]] std::string text() const;
  /// The members of an object, each a text.
  [[nodiscard]] std::map<std::string, std::string> texts() const;
  [[nodiscard]] std::string one_of(std::initializer_list<std::string_view> words) const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] long integer(long least, long most) const;
  /// @param nulls accept `null` as NaN
  [[nodiscard]] VecX vector(Eigen::Index size, bool nulls = false) const;
  [[nodiscard]] const nlohmann::json& json() const { return *json_; }

  [[noreturn]] void fail(const std::string& wanted) const;

 private:
  [[nodiscard]] JsonReader member(std::size_t i) const;

  const nlohmann::json* json_;
  std::string place_;
  std::string field_;  ///< path from the outermost object; empty: that object
};

}  // namespace baton
