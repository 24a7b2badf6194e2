/// Play between a motor with its encoder and the link that it drives.
#pragma once

namespace baton {

/// The motor crosses the play freely; at either end it drives the link. Its impact there is neglected, and while it
/// crosses, the link keeps the motor's reflected inertia.
class Backlash {
 public:
  /// @param play to each side of the middle; 0: none [rad]
  /// @param inertia of the motor, reflected to the joint [kg·m²]
  Backlash(double play, double inertia) : play_(play), inertia_(inertia) {}

  /// Torque on the link by the motor's torque [N·m] over `dt` [s].
  [[nodiscard]] double transmit(double torque, double dt);

  /// Motor's angle beyond the link's [rad], and its rate [rad/s].
  [[nodiscard]] double angle() const { return angle_; }
  [[nodiscard]] double speed() const { return speed_; }

 private:
  double play_;
  double inertia_;
  double angle_ = 0.0;
  double speed_ = 0.0;
};

}  // namespace baton
