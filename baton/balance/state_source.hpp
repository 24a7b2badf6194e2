/// Sensors used for the state of the robot.
#pragma once

#include <array>
#include <string_view>

namespace baton {

enum class StateSource {
  sensors,  ///< encoders, IMU, force sensors under the soles
  torques,  ///< encoders, IMU, motor torques
  perfect,  ///< measured root pose, in simulation only
};

[[nodiscard]] constexpr std::string_view to_string(StateSource source) {
  constexpr std::array<std::string_view, 3> names{"sensors", "torques", "perfect"};
  return names[static_cast<std::size_t>(source)];
}

}  // namespace baton
