/// Zero errors of the force sensors under the soles, learned while a foot is in the air.
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class ForceZeros {
 public:
  /// @param weight of the robot [N]
  /// @param height nominal COM height [m]
  /// @param period of the measurements [1/ω]
  ForceZeros(double weight, double height, double period) : weight_(weight), height_(height), period_(period) {}

  /// Learns from a reading, and subtracts the zero errors from it.
  /// @param planned sample of this tick
  void correct(BySide<Wrench>& sole, const MotionSample& planned);

  /// Whether the zero of a sole's sensor is known.
  [[nodiscard]] const BySide<bool>& known() const { return known_; }

 private:
  double weight_;
  double height_;
  double period_;
  BySide<Wrench> zero_;
  BySide<double> airborne_{0.0, 0.0};  ///< for how long a sole has been in the air, by plan [1/ω]
  BySide<bool> known_{false, false};
};

}  // namespace baton
