/// The remote control that comes with the robot, as its states tell of it.
#pragma once

#include <array>
#include <cstdint>

namespace baton::unitree {

struct Remote {
  bool on = false;      ///< something is received from it
  bool damp = false;    ///< L2 and B, or L1 and A: with one or the other, by its version, the maker's own gait damps
  bool stance = false;  ///< Start
};

/// @param bytes `wireless_remote` of a state: a head of 2 bytes, the buttons in the next 2, then the sticks
[[nodiscard]] Remote remote_of(const std::array<std::uint8_t, 40>& bytes);

}  // namespace baton::unitree
