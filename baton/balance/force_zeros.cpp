#include "baton/balance/force_zeros.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kLeaves = 0.3;        ///< time after lift-off for which a sole may still touch [1/ω]
constexpr double kKnown = 1.0;         ///< time in the air after which the zero is known [1/ω]
constexpr double kFirstRate = 4.0;     ///< at which an unknown zero follows the reading [ω]
constexpr double kFollowRate = 0.2;    ///< at which a known zero follows the reading [ω]
constexpr double kLeastContact = 0.6;  ///< least vertical force that is contact, not a zero error [weight]
constexpr double kOtherCarries = 0.6;  ///< least load of the other sole while a sole is in the air [weight]
constexpr double kJump = 0.04;         ///< bound of the deviation that a zero follows: more is early contact [weight]

}  // namespace

void ForceZeros::correct(BySide<Wrench>& sole, const MotionSample& planned) {
  for (const Side side : kSides) {
    Wrench& zero = zero_[side];
    double& airborne = airborne_[side];
    airborne = planned.contact[side] ? 0.0 : airborne + period_;
    const Vec3 off = sole[side].force - zero.force;
    // Planned in the air, it may stand all the same: after a fall, say.
    const bool other_carries = sole[other(side)].force.z() - zero_[other(side)].force.z() > kOtherCarries * weight_;
    if (airborne > kLeaves && other_carries && std::abs(sole[side].force.z()) < kLeastContact * weight_) {
      const double follows = std::min(1.0, period_ * (known_[side] ? kFollowRate : kFirstRate));
      zero.force += follows * (known_[side] ? bounded(off, kJump * weight_) : off);
      zero.moment += follows * bounded(Vec3(sole[side].moment - zero.moment), kJump * weight_ * height_);
      if (airborne > kKnown) known_[side] = true;
    }
  }
  for (const Side side : kSides) {
    sole[side].force -= zero_[side].force;
    sole[side].moment -= zero_[side].moment;
  }
}

}  // namespace baton
