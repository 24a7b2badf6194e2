/// Lines that are typed at a program while it does something else.
#pragma once

#include <optional>
#include <string>

namespace baton {

/// Reads standard input without waiting. Bytes that make no line for long are forgotten.
class TypedLines {
 public:
  /// The next whole line, if there is one.
  [[nodiscard]] std::optional<std::string> next();

 private:
  bool open_ = true;
  std::string typed_;
};

}  // namespace baton
