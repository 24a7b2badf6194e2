/// Distance between the robot and the world: of the feet from everything but the ground, of all other links from
/// everything.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "baton/model/world.hpp"

namespace baton {

class Obstacles {
 public:
  /// @throws InputError robot and world cannot be combined
  Obstacles(const RobotModel& robot, const World& world);

  /// Least distance at a configuration, at most `limit` [m].
  /// @param q configuration in the world (nq)
  /// @param geoms receives the closest pair, if it is closer than `limit`; `name` gives the names
  [[nodiscard]] double distance(const VecX& q, double limit, std::array<int, 2>& geoms);

  [[nodiscard]] std::string name(int geom) const { return name_of(*model_, mjOBJ_GEOM, geom); }
  [[nodiscard]] int geoms() const { return model_->ngeom; }

 private:
  /// Lower bound on the distance from a point to a geom of the world [m].
  [[nodiscard]] double least_distance(int geom, const Vec3& point) const;

  ModelPtr model_;  ///< world with robot
  DataPtr data_;
  std::vector<std::array<int, 2>> pairs_;  ///< pairs to check: geom of the robot, geom of the world
};

}  // namespace baton
