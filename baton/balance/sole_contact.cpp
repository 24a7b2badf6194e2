#include "baton/balance/sole_contact.hpp"

namespace baton {
namespace {

constexpr double kTouchdownLoad = 0.05;  ///< load at which contact begins, share of the weight
constexpr double kLiftOffLoad = 0.025;   ///< load at which contact ends, share of the weight

}  // namespace

void SoleContact::update(const BySide<double>& load) {
  load_ = load;
  for (const Side side : kSides)
    touch_[side] = load[side] > (touch_[side] ? kLiftOffLoad : kTouchdownLoad) * weight_;
  airborne_ = touch_.left || touch_.right ? 0.0 : airborne_ + period_;
}

double SoleContact::total() const {
  double total = 0.0;
  for (const Side side : kSides)
    total += touch_[side] ? load_[side] : 0.0;
  return total;
}

}  // namespace baton
