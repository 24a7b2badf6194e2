/// Estimates the drift of the IMU's yaw from stance soles: they do not turn, so their apparent rotation is drift. Soles
/// of a walking robot twist, so they tell much less than soles at rest. A drift is taken to be constant: a better
/// estimate of its rate also corrects the yaw of the time before (docs/balance.md).
#pragma once

#include "baton/balance/sole_contact.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class YawDrift {
 public:
  /// @param period of the measurements [s]
  explicit YawDrift(double period);

  /// Updates the estimate, once a tick.
  /// @param yaw of the soles, in the world, by the IMU's yaw less `error()` [rad]
  /// @param planned sample of this tick
  void update(const BySide<double>& yaw, const SoleContact& contact, const MotionSample& planned);

  /// Estimated drift [rad/s].
  [[nodiscard]] double rate() const { return rate_; }
  /// Estimated error of the IMU's yaw: the drift so far [rad].
  [[nodiscard]] double error() const { return error_; }

 private:
  /// Straight line through the yaw of resting soles over time, by least squares.
  struct Line {
    double ticks = 0.0;
    double latest = 0.0;            ///< time of the last point [s]
    double t = 0.0;                 ///< mean time [s]
    double yaw = 0.0;               ///< mean yaw [rad]
    double t_t = 0.0;               ///< sum of squared deviations [s²]
    double t_yaw = 0.0;             ///< of products of deviations [s·rad]
    double yaw_yaw = 0.0;           ///< of squared deviations [rad²]
    double rate_then = 0.0;         ///< estimate before this rest [rad/s]
    double information_then = 0.0;  ///< [s²/rad²]
  };

  /// Takes a new yaw of resting soles [rad].
  void rest(double yaw);
  /// Takes the yaw by which the sole that carries the robot has turned in this tick, beyond the drift [rad].
  void walk(double turned);
  /// Changes the estimate, and with it what it says of the time before.
  void set_rate(double rate);

  double period_;
  BySide<double> last_{0.0, 0.0};     ///< yaw by the IMU one tick ago [rad]
  BySide<bool> stood_{false, false};  ///< contacts one tick ago
  Line line_;                         ///< of this rest; no ticks: none
  double rate_ = 0.0;
  double error_ = 0.0;
  double information_;  ///< inverse variance of the rate [s²/rad²]
  double since_ = 0.0;  ///< time for which this drift has lasted [s]
};

}  // namespace baton
