/// Corrections of the robot's place by the known ground: heights are those of the ground where soles stand, and a sole
/// that stands tilted on an edge is where that edge is (docs/balance.md).
#pragma once

#include <optional>
#include <vector>

#include "baton/balance/sole_contact.hpp"
#include "baton/model/world.hpp"

namespace baton {

class MapMatching {
 public:
  /// Robot and world must outlive the object.
  MapMatching(const RobotModel& robot, const World& world);

  /// By how much the place of robot and soles is to be corrected in this tick, in the world [m].
  /// @param kinematics the robot in its attitude
  /// @param foothold where the soles are believed to be, in the world [m]
  /// @param planned which soles are meant to stand
  [[nodiscard]] Vec3 correction(const Kinematics& kinematics, const BySide<Vec3>& foothold, const SoleContact& contact,
                                const BySide<bool>& planned);

 private:
  /// Of a sole that stands tilted on an edge of the ground: the way to where that is by the map [m], zero if it is
  /// there. Nothing of a sole that stands otherwise.
  /// @param R attitude of the sole
  /// @param at its place [m]
  [[nodiscard]] std::optional<Vec2> felt_edge(Side side, const Mat3& R, const Vec3& at, const GroundPoint& below) const;

  const World* world_;
  double size_;  ///< COM height, which lengths are shares of [m]
  double period_;
  BySide<std::vector<Vec2>> corners_;  ///< of the soles, a little inside [m]
  bool lost_ = false;                  ///< the height is not known, since the robot was in the air
};

}  // namespace baton
