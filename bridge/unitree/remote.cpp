#include "bridge/unitree/remote.hpp"

#include <algorithm>

namespace baton::unitree {
namespace {

/// Bits of the buttons.
constexpr unsigned kL1 = 1U << 1U;
constexpr unsigned kStart = 1U << 2U;
constexpr unsigned kL2 = 1U << 5U;
constexpr unsigned kA = 1U << 8U;
constexpr unsigned kB = 1U << 9U;

}  // namespace

Remote remote_of(const std::array<std::uint8_t, 40>& bytes) {
  const unsigned buttons = bytes[2] | static_cast<unsigned>(bytes[3]) << 8U;
  const auto pressed = [&](unsigned all) { return (buttons & all) == all; };
  Remote remote;
  remote.on = std::ranges::any_of(bytes, [](std::uint8_t byte) { return byte != 0; });
  remote.damp = pressed(kL2 | kB) || pressed(kL1 | kA);
  remote.stance = pressed(kStart);
  return remote;
}

}  // namespace baton::unitree
