#include "baton/balance/ground_compliance.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kMeanTime = 3.0;      ///< low-pass of the means: slopes and a tilted IMU are no compliance [1/ω]
constexpr double kForgets = 60.0;      ///< time constant with which what was felt is forgotten [1/ω]
constexpr double kUsualMoment = 0.02;  ///< by which the moment on a sole varies [weight × COM height]
constexpr double kPriorTime = 6.0;     ///< for which the ground is taken to be firm at first [1/ω]
constexpr double kFirm = 0.1;          ///< what play and yielding joints make of firm ground, as `estimate`
constexpr double kTips = 0.4;          ///< share of the tilt that moments explain, up to which soles tip on edges
constexpr double kSinks = 0.7;         ///< the same, from which they sink

}  // namespace

void GroundCompliance::update(Side side, const Vec2& tilt, const Vec2& moment, bool carries) {
  if (!carries) {
    mean_[side].reset();
    return;
  }
  if (!mean_[side]) mean_[side] = Means{tilt, moment};
  Means& mean = *mean_[side];
  const double follows = std::min(1.0, period_ / kMeanTime);
  mean.tilt += follows * (tilt - mean.tilt);
  mean.moment += follows * (moment - mean.moment);
  const Vec2 t = tilt - mean.tilt;
  const Vec2 m = moment - mean.moment;
  const double forgets = period_ / kForgets;
  moment_moment_ += period_ * m.squaredNorm() - forgets * moment_moment_;
  moment_tilt_ += period_ * m.dot(t) - forgets * moment_tilt_;
  tilt_tilt_ += period_ * t.squaredNorm() - forgets * tilt_tilt_;
}

double GroundCompliance::estimate() const {
  // The ground pushes back against the tilt.
  const double found = -moment_tilt_ / (moment_moment_ + kPriorTime * kUsualMoment * kUsualMoment);
  if (found <= kFirm) return 0.0;
  const double explained = moment_tilt_ * moment_tilt_ / (moment_moment_ * tilt_tilt_);
  return (found - kFirm) * std::clamp((explained - kTips) / (kSinks - kTips), 0.0, 1.0);
}

}  // namespace baton
