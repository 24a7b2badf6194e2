/// Estimates the drift of the IMU's yaw from stance soles: they do not turn, so their apparent rotation is drift. Soles
/// of a walking robot twist a little, so they count less than soles at rest.
#pragma once

#include "baton/balance/sole_contact.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class YawDrift {
 public:
  /// @param period of the measurements [s]
  explicit YawDrift(double period) : period_(period) {}

  /// Updates the estimate, once a tick.
  /// @param yaw of the soles, in the world, with the drift estimated so far taken out [rad]
  /// @param planned sample of this tick
  void update(const BySide<double>& yaw, const SoleContact& contact, const MotionSample& planned);

  /// Estimated drift [rad/s].
  [[nodiscard]] double rate() const { return rate_; }

 private:
  double period_;
  BySide<double> last_{0.0, 0.0};     ///< yaw one tick ago [rad]
  BySide<bool> stood_{false, false};  ///< contacts one tick ago
  double rate_ = 0.0;
  double trust_ = 0.5;  ///< time of observation so far, weighted [s]
};

}  // namespace baton
