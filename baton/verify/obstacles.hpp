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

  /// Sets the configuration, in the world (nq).
  void set(const VecX& q);

  /// Least distance of a group of pairs, at most `limit` [m].
  /// @param by_map whether of trunk and legs from what cannot be stood on, else of all other pairs: an operator sees
  /// what a hand approaches, and which ground a foot stands on
  /// @param geoms receives the closest pair, if it is closer than `limit`; `name` gives the names
  [[nodiscard]] double distance(bool by_map, double limit, std::array<int, 2>& geoms) const;

  [[nodiscard]] std::string name(int geom) const { return name_of(*model_, mjOBJ_GEOM, geom); }
  [[nodiscard]] int geoms() const { return model_->ngeom; }

 private:
  /// Lower bound on the distance from a point to a geom of the world [m].
  [[nodiscard]] double least_distance(int geom, const Vec3& point) const;

  ModelPtr model_;  ///< world with robot
  DataPtr data_;
  /// Pairs to check: geom of the robot, geom of the world; and those for which the uncertainty of the place counts.
  std::vector<std::array<int, 2>> pairs_, by_map_;
};

}  // namespace baton
