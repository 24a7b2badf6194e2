/// How a simulated robot and its ground deviate from the model (docs/balance.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "baton/robot/actuators.hpp"
#include "baton/robot/sensors.hpp"

namespace baton {

/// A constant force at the trunk's COM for a short time.
struct Push {
  double t = 0.0;               ///< start [s]
  double duration = 0.05;       ///< [s]
  Vec3 impulse = Vec3::Zero();  ///< in the world frame [N·s]
};

struct Plant {
  std::optional<double> friction;  ///< friction coefficient of the soles; default: the model's
  std::optional<double> solref;    ///< contact time constant of the soles; default: the model's [s]
  double mass = 1.0;               ///< factor on all masses and inertias
  Vec3 com_offset = Vec3::Zero();  ///< displacement of the trunk's COM [m]
  ActuatorErrors actuators;
  SensorErrors sensors;
  Vec3 tilt = Vec3::Zero();  ///< rotation vector of the ground about the robot's start [rad]
  double tiles = 0.0;        ///< tiled ground: largest height deviation of a tile [m]
  double tile_side = 0.1;    ///< side length of a tile [m]
  std::vector<Push> pushes;
  std::uint64_t seed = 0;  ///< of noise and tiles

  /// Total push force at time t [N].
  [[nodiscard]] Vec3 force(double t) const;
};

/// Model text (MJCF) of world and robot, with the plant's tilt and tiles applied to the ground.
/// @param root name of the robot's root body
/// @param at the robot's initial position on the ground
/// @throws InputError tiles requested, but the ground is not a single plane
[[nodiscard]] std::string with_ground(const std::string& text, const Plant& plant, const std::string& root,
                                      const Vec3& at);

}  // namespace baton
