/// CDR, the encoding of ROS 2 messages: little-endian, each number aligned to its size.
#pragma once

#include <span>

#include "baton/mcap/bytes.hpp"

namespace baton::mcap {

inline constexpr std::string_view kCdrHead{"\0\1\0\0", 4};  ///< plain CDR, little-endian

/// Begins a message in `out`.
class CdrWriter {
 public:
  explicit CdrWriter(std::string& out) : out_(&out) { out = kCdrHead; }

  template <typename T>
  CdrWriter& number(std::type_identity_t<T> value) {
    align(sizeof(T));
    put<T>(*out_, value);
    return *this;
  }
  CdrWriter& text(std::string_view text) {
    number<std::uint32_t>(static_cast<std::uint32_t>(text.size() + 1));
    out_->append(text);
    out_->push_back('\0');
    return *this;
  }
  /// An array of fixed length.
  template <typename T>
  CdrWriter& array(std::span<const T> values) {
    for (const T value : values)
      number<T>(value);
    return *this;
  }
  /// An array whose length is said.
  template <typename T>
  CdrWriter& sequence(std::span<const T> values) {
    number<std::uint32_t>(static_cast<std::uint32_t>(values.size()));
    return array<T>(values);
  }

 private:
  void align(std::size_t size) {
    const std::size_t at = out_->size() - kCdrHead.size();
    out_->append((size - at % size) % size, '\0');
  }

  std::string* out_;
};

/// Takes a message apart. @throws Malformed it is not what is asked for
class CdrReader {
 public:
  explicit CdrReader(std::string_view message) : cursor_(message) {
    if (cursor_.take(kCdrHead.size()) != kCdrHead) throw Malformed("is not little-endian CDR");
  }

  template <typename T>
  [[nodiscard]] T number() {
    const std::size_t at = cursor_.at() - kCdrHead.size();
    static_cast<void>(cursor_.take((sizeof(T) - at % sizeof(T)) % sizeof(T)));
    return cursor_.number<T>();
  }
  [[nodiscard]] std::string_view text() {
    const std::string_view text = cursor_.take(number<std::uint32_t>());
    if (text.empty() || text.back() != '\0') throw Malformed("has a text without end");
    return text.substr(0, text.size() - 1);
  }
  template <typename T>
  void array(std::span<T> values) {
    for (T& value : values)
      value = number<T>();
  }
  /// @tparam Values std::vector or an Eigen vector
  template <typename Values>
  [[nodiscard]] Values sequence() {
    using T = typename Values::value_type;
    const auto size = number<std::uint32_t>();
    if (size > kMost) throw Malformed("has an array that is too long");
    Values values(size);
    for (T& value : values)
      value = number<T>();
    return values;
  }

  static constexpr std::uint32_t kMost = 10000;  ///< members of an array

 private:
  Cursor cursor_;
};

}  // namespace baton::mcap
