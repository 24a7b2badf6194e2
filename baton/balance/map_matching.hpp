/// Map matching: corrects the estimated position by the known terrain. Soles in contact are at its height; a sole that
/// stands at another height than the terrain below, or has a corner inside higher ground, is beyond an edge; and one
/// that is tilted on an edge is at that edge (docs/balance.md).
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

  /// Correction of the position of robot and soles in this tick, in the world [m].
  /// @param kinematics set to the measured configuration; the root's position does not matter
  /// @param foothold estimated positions of the soles, in the world [m]
  /// @param planned planned contacts
  [[nodiscard]] Vec3 correction(const Kinematics& kinematics, const BySide<Vec3>& foothold, const SoleContact& contact,
                                const BySide<bool>& planned);

 private:
  /// For a sole that is tilted on a terrain edge: displacement to that edge in the map [m], zero if the sole is there.
  /// Empty for any other sole.
  /// @param R attitude of the sole
  /// @param at estimated position of the sole [m]
  /// @param below terrain there
  [[nodiscard]] std::optional<Vec2> felt_edge(Side side, const Mat3& R, const Vec3& at, const GroundPoint& below) const;

  /// For a level sole: displacement to the nearest ground of its height [m]. Zero if the sole's centre is on such
  /// ground and no corner within higher ground, which it cannot be, or if there is none nearby.
  /// @param below terrain below the sole's centre
  [[nodiscard]] Vec2 to_own_height(Side side, const Mat3& R, const Vec3& at, const GroundPoint& below) const;

  const World* world_;
  double com_height_;  ///< COM height, unit of lengths [m]
  double omega_;       ///< [1/s]
  double period_;
  BySide<std::vector<Vec2>> corners_;        ///< of the soles, inset a little, in the sole frame [m]
  BySide<std::vector<Vec2>> outer_corners_;  ///< the same, outset a little
  bool height_lost_ = false;                 ///< height unknown, as the robot was in the air
};

}  // namespace baton
