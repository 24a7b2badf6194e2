/// Compliance of the ground, as the soles feel it: how far one turns under a moment. A floor hardly gives, a foam mat
/// more than the servos (docs/balance.md).
#pragma once

#include <optional>

#include "baton/math/pose.hpp"
#include "baton/model/side.hpp"

namespace baton {

class GroundCompliance {
 public:
  /// @param period of the updates [1/ω]
  explicit GroundCompliance(double period) : period_(period) {}

  /// Once a tick, for each sole.
  /// @param tilt of the sole against the plan, about horizontal axes [rad]
  /// @param moment of the ground on it, about the same axes [weight × COM height]
  /// @param carries whether it carries enough to tell anything
  void update(Side side, const Vec2& tilt, const Vec2& moment, bool carries);

  /// [rad per weight × COM height]; 0 for ground that is firm, or where a sole tips instead of sinking.
  [[nodiscard]] double estimate() const;

 private:
  struct Means {
    Vec2 tilt;
    Vec2 moment;
  };

  double period_;
  BySide<std::optional<Means>> mean_;  ///< low-passed, since the sole landed
  // Sums of products of what differs from the means, with a memory that fades.
  double moment_moment_ = 0.0;
  double moment_tilt_ = 0.0;
  double tilt_tilt_ = 0.0;
};

}  // namespace baton
