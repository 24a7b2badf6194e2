#include "baton/balance/torque_scale.hpp"

#include <algorithm>
#include <span>

namespace baton {
namespace {

constexpr double kLearnsFirst = 0.5;   ///< time constant at first [1/ω]
constexpr double kLearns = 4.0;        ///< time constant at last [1/ω]
constexpr double kLeastExcess = -0.4;  ///< bounds of the excess: torque by 0.6 …
constexpr double kMostExcess = 0.7;    ///< … to 1.7
constexpr double kLittleLoad = 0.01;   ///< sum of squared torques, in stall torques, below which little is learned
constexpr std::size_t kAnkle = 2;      ///< joints of the ankle

}  // namespace

TorqueScale::TorqueScale(const RobotModel& robot)
    : robot_(&robot), period_(robot.omega() * robot.profile().tick.period), learned_(kLearnsFirst) {}

void TorqueScale::update(const Eigen::Ref<const VecX>& torque, const Eigen::Ref<const VecX>& error) {
  // Normalised least mean squares over hips and knees. Ankles are left out: on soft ground soles turn with the moment
  // that an ankle exerts, and its servo's error has the opposite sign.
  double missing = 0.0;
  double loaded = 0.0;
  for (const Side side : kSides) {
    const std::vector<int>& leg = robot_->leg(side);
    for (const int j : std::span(leg).first(leg.size() - kAnkle)) {
      const Joint& joint = robot_->joints()[static_cast<std::size_t>(j)];
      const double load = torque[j] / joint.motor.stall;
      missing += joint.gains.kp * error[j] / joint.motor.stall * load;
      loaded += load * load;
    }
  }
  excess_ =
      std::clamp(excess_ + period_ / learned_ * missing / std::max(loaded, kLittleLoad), kLeastExcess, kMostExcess);
  learned_ = std::min(learned_ + period_, kLearns);
}

}  // namespace baton
