/// What is different about a simulated robot and its world from what the program believes (docs/balance.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "baton/robot/actuators.hpp"
#include "baton/robot/sensors.hpp"

namespace baton {

/// A force on the trunk, at its COM, for a moment.
struct Push {
  double t = 0.0;               ///< when it begins [s]
  double duration = 0.05;       ///< [s]
  Vec3 impulse = Vec3::Zero();  ///< in the world [N·s]
};

struct Plant {
  std::optional<double> friction;  ///< coefficient of the soles, instead of the model's
  std::optional<double> solref;    ///< time constant of contact at the soles, instead of the model's [s]
  double mass = 1.0;               ///< factor on all masses and inertias
  Vec3 com_offset = Vec3::Zero();  ///< of the trunk's COM [m]
  ActuatorErrors actuators;
  SensorErrors sensors;
  Vec3 tilt = Vec3::Zero();  ///< rotation vector of the ground about the robot's start [rad]
  double tiles = 0.0;        ///< the ground is of tiles, each higher or lower by up to this [m]
  double tile_side = 0.1;    ///< of a tile [m]
  std::vector<Push> pushes;
  std::uint64_t seed = 0;  ///< of noise and tiles

  /// Sum of the forces of the pushes at a time [N].
  [[nodiscard]] Vec3 force(double t) const;
};

/// Model text of world and robot → the same with the ground tilted and tiled as the plant has it.
/// @param root name of the robot's root body
/// @param at the robot's start on the ground
/// @throws InputError tiles on ground that is not one plane
[[nodiscard]] std::string with_ground(const std::string& text, const Plant& plant, const std::string& root,
                                      const Vec3& at);

}  // namespace baton
