/// Reads a robot's model, MJCF or URDF, into the form that the rest of the library relies on: one tree of named links
/// below a free joint, a torque motor at each hinge, geoms that touch the world's but not each other's, pairs of geoms
/// for self-collision, sites where the profile names bodies.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "baton/model/mujoco.hpp"

namespace baton {

/// What a profile adds to a model.
struct ModelChanges {
  /// Motor of one joint; values that are 0 leave the model's.
  struct Motor {
    double torque = 0.0;    ///< stall torque [N·m]
    double armature = 0.0;  ///< reflected inertia [kg·m²]
  };
  std::map<std::string, Motor> motors;  ///< by joint name
  std::vector<std::string> sites;       ///< sites, or bodies that get one of their name at their origin
  std::vector<std::string> hands;       ///< the same, at the body's COM
  std::vector<std::string> rigid;       ///< joints that are held at zero
  std::vector<std::array<std::string, 2>>
      self_pairs;  ///< geoms that must not touch each other; empty: the model's pairs

  bool operator==(const ModelChanges&) const = default;
};

/// Whether a model has the geoms that touch nothing. Only pictures need them, and their meshes take most of the time
/// and memory that a model takes to be read.
enum class Visuals { keep, drop };

/// Reads a model file.
///
/// - Mesh and texture files get absolute names, so that the model can be combined with others.
/// - The robot is the body with the free joint or, if there is none, the first body with hinges below it, which gets
///   one. Everything else in the world of the file is dropped, with what refers to it; if anything is changed,
///   keyframes, sensors and tendons are dropped too.
/// - Bodies, joints and colliding geoms without a name get one.
/// - Actuators are replaced by one torque motor for each hinge, whose range is the least of the limits that the model
///   states (`actuatorfrcrange`, `forcerange`, `ctrlrange` of a torque motor); without any, it has none.
/// - If the robot's geoms could touch each other, they no longer do, except for pairs.
///
/// A model that is in that form already is not changed. Of visual geoms, those whose masses make a body's inertia stay.
/// @throws InputError no such file, not a model, no hinges, a joint that is neither a hinge nor the free one
[[nodiscard]] SpecPtr read_robot(const std::filesystem::path& file, const ModelChanges& changes,
                                 Visuals visuals = Visuals::keep);

}  // namespace baton
