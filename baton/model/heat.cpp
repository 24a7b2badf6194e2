#include "baton/model/heat.hpp"

#include <algorithm>
#include <cmath>

#include "baton/model/robot_model.hpp"

namespace baton {

double steady(const Thermal& motor, double torque) {
  const double ratio = torque / motor.continuous;
  return ratio * ratio;
}

Warmth after(const Thermal& motor, const Warmth& before, double torque, double time) {
  const double end = steady(motor, torque);
  const auto towards = [time](double from, double to, double constant) {
    return from - std::expm1(-time / constant) * (to - from);
  };
  return {towards(before.winding, motor.winding * end, motor.winding_time),
          towards(before.housing, (1.0 - motor.winding) * end, motor.housing_time)};
}

Hottest hottest(const Heat& heat) {
  Hottest found;
  for (std::size_t j = 0; j < heat.size(); ++j) {
    if (heat[j].total() > found.total) found = {static_cast<int>(j), heat[j].total()};
  }
  return found;
}

Heat at_least(Heat heat, double total) {
  for (Warmth& motor : heat)
    motor.housing += std::max(0.0, total - motor.total());
  return heat;
}

HeatModel::HeatModel(const RobotModel& robot) {
  const double period = robot.profile().tick.period;
  for (const Joint& joint : robot.joints()) {
    const Thermal& thermal = joint.motor.thermal;
    motors_.push_back({thermal, joint.motor.stall, -std::expm1(-period / thermal.winding_time),
                       -std::expm1(-period / thermal.housing_time)});
    limited_ = limited_ || std::isfinite(thermal.continuous);
  }
}

void HeatModel::step(Heat& heat, const VecX& torque) const {
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    const Part& motor = motors_[j];
    const double end = steady(motor.thermal, torque[static_cast<Eigen::Index>(j)] / motor.stall);
    const double share = motor.thermal.winding;
    heat[j].winding += motor.winding_step * (share * end - heat[j].winding);
    heat[j].housing += motor.housing_step * ((1.0 - share) * end - heat[j].housing);
  }
}

Hottest HeatModel::held(const VecX& torque) const {
  Hottest found;
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    const double end = steady(motors_[j].thermal, torque[static_cast<Eigen::Index>(j)] / motors_[j].stall);
    if (end > found.total) found = {static_cast<int>(j), end};
  }
  return found;
}

}  // namespace baton
