/// Left and right.
#pragma once

#include <array>

namespace baton {

enum class Side { left, right };

inline constexpr std::array<Side, 2> kSides{Side::left, Side::right};

[[nodiscard]] constexpr Side other(Side side) {
  return side == Side::left ? Side::right : Side::left;
}

/// +1 on the left (+y), −1 on the right.
[[nodiscard]] constexpr double sign_of(Side side) {
  return side == Side::left ? 1.0 : -1.0;
}

/// One value for each side.
template <typename T>
struct BySide {
  T left{};
  T right{};
  [[nodiscard]] constexpr T& operator[](Side side) { return side == Side::left ? left : right; }
  [[nodiscard]] constexpr const T& operator[](Side side) const { return side == Side::left ? left : right; }
};

}  // namespace baton
