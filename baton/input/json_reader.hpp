/// Reads JSON that somebody else may have written: every complaint is one line that names the place, the field, the
/// value and what it must be.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

/// Cut to a size that fits a message, between two characters of UTF-8.
[[nodiscard]] std::string shortened(std::string text, std::size_t longest);

/// A value as in the file, cut to a size that fits a message.
[[nodiscard]] std::string shown(const nlohmann::json& value);

/// What the parser has against a text, without the class of the error and the line number, which is always 1.
[[nodiscard]] std::string reason(const nlohmann::json::exception& error);

/// @param place file, and line if there are several: it begins every message
/// @throws InputError not JSON, or brackets nested more than 32 deep
[[nodiscard]] nlohmann::json parse_json(std::string_view text, const std::string& place);

/// A value and where it is. All members throw InputError for a value that is not what they are asked for.
class JsonReader {
 public:
  /// @param json must outlive the object
  JsonReader(const nlohmann::json& json, std::string place, std::string field = "")
      : json_(&json), place_(std::move(place)), field_(std::move(field)) {}

  [[nodiscard]] bool has(const char* key) const { return json_->is_object() && json_->contains(key); }
  /// @throws InputError also: it is missing
  [[nodiscard]] JsonReader at(const char* key) const;
  /// The members of a list.
  /// @param size none: any but 0
  [[nodiscard]] std::vector<JsonReader> list(std::optional<std::size_t> size = std::nullopt) const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::string one_of(std::initializer_list<std::string_view> words) const;
  [[nodiscard]] bool truth() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] long whole(long least, long most) const;
  /// @param nulls `null` stands for a value that is not a number
  [[nodiscard]] VecX vector(Eigen::Index size, bool nulls = false) const;
  [[nodiscard]] const nlohmann::json& json() const { return *json_; }

  [[noreturn]] void complain(const std::string& wanted) const;

 private:
  [[nodiscard]] JsonReader member(std::size_t i) const;

  const nlohmann::json* json_;
  std::string place_;
  std::string field_;  ///< its name from the outermost object on; empty: that object itself
};

}  // namespace baton
