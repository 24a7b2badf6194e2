/// How a simulated robot and its ground deviate from the model (docs/balance.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton {

/// A constant force for some time.
struct Push {
  double t = 0.0;               ///< start [s]
  double duration = 0.05;       ///< [s]
  Vec3 impulse = Vec3::Zero();  ///< in the world frame [N·s]
  std::optional<Side> hand{};   ///< hand that it acts on; none: the trunk's COM

  bool operator==(const Push&) const = default;
};

struct Plant {
  std::optional<double> friction;    ///< friction coefficient of the soles; default: the model's
  std::optional<double> solref;      ///< contact time constant of the soles; default: the model's [s]
  double mat = 0.0;                  ///< depth by which the standing robot sinks into a soft mat; 0: none [m]
  double mass = 1.0;                 ///< factor on all masses and inertias
  Vec3 com_offset = Vec3::Zero();    ///< displacement of the trunk's COM [m]
  BySide<double> payload{0.0, 0.0};  ///< mass of a ball at each hand, which touches nothing [kg]
  ActuatorErrors actuators;
  SensorErrors sensors;
  Vec3 tilt = Vec3::Zero();  ///< rotation vector of the ground about the robot's start [rad]
  double tiles = 0.0;        ///< tiled ground: largest height deviation of a tile [m]
  double tile_side = 0.1;    ///< side length of a tile [m]
  std::vector<Push> pushes;
  std::uint64_t seed = 0;  ///< of the sensors' errors and the tiles

  bool operator==(const Plant&) const = default;

  /// Total push force on a hand, or on the trunk, at time t [N].
  [[nodiscard]] Vec3 force(double t, std::optional<Side> hand = std::nullopt) const;
};

/// Index of the leg's first joint about a forward axis, its abduction.
/// @throws InputError the leg has none
[[nodiscard]] int abduction(const RobotModel& robot, Side side);

/// The plant `real`: the errors of sensors and actuators that the profile states.
/// @param seed draws the constant ones
[[nodiscard]] Plant real_plant(const RobotModel& robot, std::uint64_t seed);

/// Model text (MJCF) of world and robot, changed as the plant deviates from it: ground, contact, masses, and the
/// mechanics of the joints except backlash.
/// @param at the robot's initial position on the ground
/// @throws InputError tiles requested, but the ground is not a single plane
[[nodiscard]] std::string with_plant(const std::string& text, const Plant& plant, const RobotModel& robot,
                                     const Vec3& at);

}  // namespace baton
