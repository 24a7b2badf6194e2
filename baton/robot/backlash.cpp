#include "baton/robot/backlash.hpp"

#include <algorithm>

namespace baton {

double Backlash::transmit(double torque, double dt) {
  const bool crosses = (torque > 0.0 && angle_ < play_) || (torque < 0.0 && angle_ > -play_);
  if (!crosses) {
    speed_ = 0.0;
    return torque;
  }
  speed_ += torque / inertia_ * dt;
  const double moved = angle_ + speed_ * dt;
  angle_ = std::clamp(moved, -play_, play_);
  if (moved != angle_) speed_ = 0.0;
  return 0.0;
}

}  // namespace baton
