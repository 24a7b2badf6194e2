#include "baton/balance/yaw_drift.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kFastest = 0.05;  ///< largest drift [rad/s]
constexpr double kTwist = 1.0;     ///< yaw rate of a sole from which it slips [rad/s]
constexpr double kStill = 1e-3;    ///< planned speed at rest: norm over all joints [rad/s]
constexpr double kTurns = 0.02;    ///< planned yaw rate of the root from which soles twist to one side [rad/s]
constexpr double kWalking = 0.1;  ///< weight of a walking robot's soles against those at rest
constexpr double kPrior = 5.5;     ///< time of observation that no drift, as one expects, counts for [s]
constexpr double kMemory = 60.0;   ///< longest time of observation that counts [s]

}  // namespace

void YawDrift::update(const BySide<double>& yaw, const SoleContact& contact, const MotionSample& planned) {
  const double total = contact.total();
  const bool both = planned.contact.left && planned.contact.right;
  const bool rests = both && planned.dq.norm() < kStill;
  double turned = 0.0;
  double share = 0.0;
  for (const Side side : kSides) {
    const bool stands = planned.contact[side] && contact.touch()[side];
    if (stands && stood_[side] && total > 0.0) {
      const double part = contact.load()[side] / total;
      turned += part * wrap_angle(yaw[side] - last_[side]);
      share += part;
    }
    stood_[side] = stands;
    last_[side] = yaw[side];
  }
  if (share < 0.5 || std::abs(turned) > kTwist * period_) return;
  if (!rests && std::abs(planned.dq[5]) > kTurns) return;
  const double weight = rests ? 1.0 : kWalking;
  trust_ = std::min(trust_ + weight * period_, kMemory);
  rate_ = std::clamp(rate_ + weight * turned / share / (kPrior + trust_), -kFastest, kFastest);
}

}  // namespace baton
