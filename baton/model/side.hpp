/// Left and right.
#pragma once

#include <array>
#include <string_view>

#include "baton/math/pose.hpp"

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

[[nodiscard]] constexpr std::string_view to_string(Side side) {
  return side == Side::left ? "left" : "right";
}

/// A pair of values, left and right.
template <typename T>
struct BySide {
  T left{};
  T right{};
  [[nodiscard]] constexpr T& operator[](Side side) { return side == Side::left ? left : right; }
  [[nodiscard]] constexpr const T& operator[](Side side) const { return side == Side::left ? left : right; }

  bool operator==(const BySide&) const = default;
};

/// Mean yaw of the soles, which is the yaw of the heading frame [rad].
[[nodiscard]] inline double mean_yaw(const BySide<Pose>& sole) {
  return mean_yaw(yaw_of(sole.left.R), yaw_of(sole.right.R));
}

}  // namespace baton
