#include "baton/balance/sole_contact.hpp"

namespace baton {
namespace {

constexpr double kTouches = 0.05;  ///< share of the weight from which a sole counts as touching
constexpr double kLeaves = 0.025;  ///< share below which it does no more

}  // namespace

void SoleContact::update(const BySide<double>& load) {
  load_ = load;
  for (const Side side : kSides)
    touch_[side] = load[side] > (touch_[side] ? kLeaves : kTouches) * weight_;
  airborne_ = touch_.left || touch_.right ? 0.0 : airborne_ + period_;
}

double SoleContact::total() const {
  double total = 0.0;
  for (const Side side : kSides)
    total += touch_[side] ? load_[side] : 0.0;
  return total;
}

}  // namespace baton
