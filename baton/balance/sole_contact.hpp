/// Contact detection: which soles are in contact, by their load, with hysteresis.
#pragma once

#include "baton/model/contact.hpp"

namespace baton {

class SoleContact {
 public:
  /// Initially both soles are in contact.
  /// @param weight weight of the robot [N]
  /// @param period time between measurements [s]
  SoleContact(double weight, double period) : weight_(weight), period_(period) {}

  /// @param load vertical force on each sole [N]
  void update(const BySide<double>& load);

  /// Vertical force on each sole [N].
  [[nodiscard]] const BySide<double>& load() const { return load_; }
  /// Whether a sole is in contact.
  [[nodiscard]] const BySide<bool>& touch() const { return touch_; }
  /// Total load of the soles in contact [N].
  [[nodiscard]] double total() const;
  /// Time since the last contact of any sole [s].
  [[nodiscard]] double airborne() const { return airborne_; }

 private:
  double weight_;
  double period_;
  BySide<double> load_;
  BySide<bool> touch_{true, true};
  double airborne_ = 0.0;
};

}  // namespace baton
