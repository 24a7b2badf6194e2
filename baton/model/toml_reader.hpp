/// Reading TOML files that people write: whatever is wrong in them is told in one line.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/model/profile.hpp"

namespace baton {

/// @param kind of the file, for messages: "profile", …
/// @throws InputError file missing or not TOML
[[nodiscard]] inline toml::table parse_toml(const std::filesystem::path& file, const std::string& kind) {
  try {
    return toml::parse(read_input(file, kind), file.string());
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{} {}: line {}: {}", kind, file.string(), error.source().begin.line, error.description()));
  }
}

/// Reads the keys of a table. Errors name file, key, value and what is expected. Keys are paths: "table.key".
class TomlReader {
 public:
  /// The table must outlive the object.
  /// @param kind of the file, for messages: "profile", …
  TomlReader(const toml::table& table, std::string kind, const std::filesystem::path& file)
      : table_(table), kind_(std::move(kind)), file_(file.string()) {}

  [[nodiscard]] std::string text(const std::string& key) const {
    const auto value = at(key).value<std::string>();
    if (!value || value->empty()) complain(key, "a non-empty string");
    return *value;
  }

  [[nodiscard]] double number(const std::string& key, double lo, double hi) const {
    return checked(key, at(key), lo, hi);
  }

  [[nodiscard]] double positive(const std::string& key, double hi) const {
    const double value = number(key, 0.0, hi);
    if (value == 0.0) complain(key, "more than 0");
    return value;
  }

  template <std::size_t N>
  [[nodiscard]] std::array<double, N> numbers(const std::string& key, double lo, double hi) const {
    const toml::node_view<const toml::node> node = at(key);
    const toml::array* array = node.as_array();
    if (array == nullptr || array->size() != N) complain(key, fmt::format("an array of {} numbers", N));
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i)
      values[i] = checked(key, node[i], lo, hi);
    return values;
  }

  [[nodiscard]] double number_or(const std::string& key, double lo, double hi, double missing) const {
    return at(key) ? number(key, lo, hi) : missing;
  }

  [[nodiscard]] bool flag_or(const std::string& key, bool missing) const {
    const auto node = at(key);
    if (!node) return missing;
    if (!node.is_boolean()) complain(key, "true or false");
    return *node.value<bool>();
  }

  [[nodiscard]] Range range(const std::string& key, double lo, double hi) const {
    const auto [a, b] = numbers<2>(key, lo, hi);
    if (!(a < b)) complain(key, "[lowest, highest] with lowest < highest");
    return {a, b};
  }

  [[nodiscard]] std::map<std::string, double> table(const std::string& key, double lo, double hi) const {
    const toml::table* entries = at(key).as_table();
    if (entries == nullptr) complain(key, "a table of numbers");
    std::map<std::string, double> values;
    for (const auto& [name, node] : *entries) {
      const std::string joint(name.str());
      values[joint] = number(key + "." + joint, lo, hi);
    }
    return values;
  }

  [[nodiscard]] toml::node_view<const toml::node> at(const std::string& key) const {
    asked_.insert(key);
    return table_.at_path(key);
  }

  /// Call it after all keys were read.
  void complain_of_unknown_keys() const { complain_of_unknown_keys(table_, ""); }

  [[noreturn]] void complain(const std::string& key, const std::string& wanted) const {
    const auto node = table_.at_path(key);
    std::ostringstream value;
    if (node) {
      node.visit([&value](const auto& n) {
        if constexpr (requires { value << n; }) value << n;
      });
    }
    std::string shown;  // on one line
    for (const char c : value.str()) {
      const bool indent = c == ' ' && (shown.ends_with(' ') || shown.ends_with('['));
      if (c != '\n' && !indent) shown += c;
    }
    throw InputError(node ? fmt::format("{} {}: {} = {}: must be {}", kind_, file_, key, shown, wanted)
                          : fmt::format("{} {}: {} is missing: must be {}", kind_, file_, key, wanted));
  }

 private:
  void complain_of_unknown_keys(const toml::node& node, const std::string& key) const {
    const toml::array* array = node.as_array();
    if (const toml::table* entries = node.as_table()) {
      for (const auto& [name, entry] : *entries) {
        const std::string prefix = key.empty() ? "" : key + ".";
        complain_of_unknown_keys(entry, prefix + std::string(name.str()));
      }
    } else if (array != nullptr && array->is_array_of_tables()) {
      for (std::size_t i = 0; i < array->size(); ++i) {
        complain_of_unknown_keys((*array)[i], fmt::format("{}[{}]", key, i));
      }
    } else if (!asked_.contains(key)) {
      throw InputError(fmt::format("{0} {1}: {2}: a {0} has no such key", kind_, file_, key));
    }
  }

  [[nodiscard]] double checked(const std::string& key, toml::node_view<const toml::node> node, double lo,
                               double hi) const {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value) || *value < lo || *value > hi) {
      complain(key, fmt::format("a number from {} to {}", lo, hi));
    }
    return *value;
  }

  const toml::table& table_;
  std::string kind_;
  std::string file_;
  mutable std::set<std::string> asked_;  ///< keys looked up so far
};

}  // namespace baton
