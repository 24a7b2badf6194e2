#include "baton/balance/yaw_drift.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kUsualDrift = 1.7e-3;  ///< standard deviation of the drift that one expects [rad/s]
constexpr double kTwists = 3e-3;        ///< that of the turn of a walking robot's soles, after a second [rad]
constexpr double kNoise = 1e-5;         ///< that of the yaw of resting soles, at least [rad]
constexpr double kErrorsLast =
    10.0;  ///< time for which its errors last, as the robot settles into its joints' play [s]
constexpr double kStepErrors =
    5e-4;                           ///< standard deviation of a rate from walking: errors that repeat each step [rad/s]
constexpr double kLeastRest = 0.8;  ///< shortest rest that counts [s]
constexpr double kCreep = 1e-4;     ///< standard deviation of the rate at which resting soles creep [rad/s]
constexpr double kLongestDrift = 60.0;  ///< longest time for which a drift is taken to have lasted [s]
constexpr double kCarriesAlone = 0.9;   ///< share of the load from which a sole does not twist
constexpr double kLargestDrift = 0.05;  ///< largest drift [rad/s]
constexpr double kSlips = 1.0;          ///< yaw rate of a sole from which it slips [rad/s]
constexpr double kStill = 1e-3;         ///< planned speed at rest: norm over all joints [rad/s]
constexpr double kTurning = 0.02;       ///< planned yaw rate of the root from which soles twist to one side [rad/s]

}  // namespace

YawDrift::YawDrift(double period) : period_(period), information_(1.0 / (kUsualDrift * kUsualDrift)) {}

void YawDrift::update(const BySide<double>& yaw, const SoleContact& contact, const MotionSample& planned) {
  const bool rests = planned.contact.left && planned.contact.right && planned.dq.norm() < kStill &&
                     contact.touch().left && contact.touch().right;
  double mean = 0.0;
  double turned = 0.0;
  bool alone = false;
  bool slips = false;
  for (const Side side : kSides) {
    const double by_imu = yaw[side] + error_;
    const double turn = wrap_angle(by_imu - last_[side]) - period_ * rate_;
    const bool stands = planned.contact[side] && contact.touch()[side];
    if (stands && stood_[side]) {
      slips = slips || std::abs(turn) > kSlips * period_;
      if (contact.load()[side] > kCarriesAlone * contact.total()) {
        alone = true;
        turned = turn;
      }
    }
    stood_[side] = stands;
    last_[side] = by_imu;
    mean += 0.5 * by_imu;
  }
  if (rests && !slips) {
    rest(mean);
  } else {
    line_ = {};
    if (alone && !slips && !rests && std::abs(planned.dq[5]) < kTurning) walk(turned);
  }
  since_ = std::min(since_ + period_, kLongestDrift);
  error_ += period_ * rate_;
}

void YawDrift::rest(double yaw) {
  if (line_.ticks == 0.0) line_ = {.yaw = yaw, .rate_then = rate_, .information_then = information_};
  // Means and sums of squares by Welford's recursion.
  line_.ticks += 1.0;
  line_.latest += period_;
  const double t = line_.latest - line_.t;
  const double off = wrap_angle(yaw - line_.yaw);
  line_.t += t / line_.ticks;
  line_.yaw += off / line_.ticks;
  const double off_new = wrap_angle(yaw - line_.yaw);
  line_.t_t += t * (line_.latest - line_.t);
  line_.t_yaw += t * off_new;
  line_.yaw_yaw += off * off_new;
  if (line_.latest < kLeastRest) return;
  const double slope = line_.t_yaw / line_.t_t;
  const double residual = std::max(0.0, line_.yaw_yaw - slope * line_.t_yaw) / line_.ticks;
  const double variance = (residual + kNoise * kNoise) * kErrorsLast / period_ / line_.t_t + kCreep * kCreep;
  information_ = line_.information_then + 1.0 / variance;
  set_rate((line_.information_then * line_.rate_then + slope / variance) / information_);
  information_ = std::min(information_, 1.0 / (kCreep * kCreep));
}

void YawDrift::walk(double turned) {
  const double information = period_ / (kTwists * kTwists);
  if (information_ > 1.0 / (kStepErrors * kStepErrors)) return;
  information_ += information;
  set_rate(rate_ + information / information_ * turned / period_);
}

void YawDrift::set_rate(double rate) {
  const double before = rate_;
  rate_ = std::clamp(rate, -kLargestDrift, kLargestDrift);
  error_ += since_ * (rate_ - before);
}

}  // namespace baton
