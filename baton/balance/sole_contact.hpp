/// Which soles touch the ground, by the load on each, with a hysteresis.
#pragma once

#include "baton/model/contact.hpp"

namespace baton {

class SoleContact {
 public:
  /// Both soles touch to begin with.
  /// @param weight of the robot [N]
  /// @param period of the measurements [s]
  SoleContact(double weight, double period) : weight_(weight), period_(period) {}

  /// @param load vertical force on each sole [N]
  void update(const BySide<double>& load);

  /// Vertical force on each sole [N].
  [[nodiscard]] const BySide<double>& load() const { return load_; }
  /// Whether a sole carries some of the weight.
  [[nodiscard]] const BySide<bool>& touch() const { return touch_; }
  /// The load of the soles that touch [N].
  [[nodiscard]] double total() const;
  /// For how long no sole has touched [s].
  [[nodiscard]] double airborne() const { return airborne_; }

 private:
  double weight_;
  double period_;
  BySide<double> load_;
  BySide<bool> touch_{true, true};
  double airborne_ = 0.0;
};

}  // namespace baton
