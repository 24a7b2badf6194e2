/// Distance of the robot's links from the world: of soles from all that may not be stood on, of all other links from
/// everything.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "baton/model/world.hpp"

namespace baton {

class Obstacles {
 public:
  /// @throws InputError robot and world do not go together
  Obstacles(const RobotModel& robot, const World& world);

  /// Least distance [m] at a configuration in the world, as far as it is less than `limit`; `limit` otherwise.
  /// `geoms` receives the nearest pair, to be named by `name`.
  [[nodiscard]] double distance(const VecX& q, double limit, std::array<int, 2>& geoms);

  [[nodiscard]] std::string name(int geom) const { return name_of(*model_, mjOBJ_GEOM, geom); }
  [[nodiscard]] int geoms() const { return model_->ngeom; }

 private:
  /// A bound from below on the distance of a point from a geom of the world [m].
  [[nodiscard]] double least_distance(int geom, const Vec3& point) const;

  ModelPtr model_;  ///< world and robot
  DataPtr data_;
  std::vector<std::array<int, 2>> pairs_;  ///< colliding geoms, of the robot and of the world
};

}  // namespace baton
