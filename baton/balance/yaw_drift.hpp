/// Drift of the IMU's yaw: a stance sole does not turn, so what it seems to turn is drift. Soles twist a little while the
/// robot walks, so this counts less then than at rest.
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

  /// [rad/s]
  [[nodiscard]] double rate() const { return rate_; }

 private:
  double period_;
  BySide<double> last_{0.0, 0.0};           ///< yaw one tick ago [rad]
  BySide<bool> stood_{false, false};        ///< contacts one tick ago
  double rate_ = 0.0;
  double trust_ = 0.5;  ///< time of observation so far, weighted [s]
};

}  // namespace baton
