#include "baton/navigate/thermometer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace baton {
namespace {

constexpr double kCooled = 0.7;      ///< rise below which the robot goes on [permitted rise]
constexpr double kSettled = 0.02;    ///< distance from its final rise at which a motor gets no cooler [permitted rise]
constexpr double kSettling = 5.0;    ///< time after which the winding tells that final rise [its time constant]
constexpr double kHotReserve = 0.1;  ///< between that rise and the one at which the robot is hot again [permitted rise]
constexpr double kHottest = 0.95;    ///< rise at which it is hot in any case [permitted rise]
constexpr double kTorque = 1.5;      ///< largest motor torque, as currents tell it [stall torque]

}  // namespace

Thermometer::Thermometer(const RobotModel& robot)
    : robot_(&robot), model_(robot), heat_(model_.cold()), torque_(VecX::Zero(robot.nv() - 6)) {}

void Thermometer::update(const Measurement& measured, const JointTarget& commanded) {
  if (!model_.limited()) return;
  for (Eigen::Index j = 0; j < torque_.size(); ++j) {
    const Motor& motor = robot_->joints()[static_cast<std::size_t>(j)].motor;
    const bool told = measured.torque.size() == torque_.size() && std::abs(measured.torque[j]) <= kTorque * motor.stall;
    torque_[j] =
        told ? measured.torque[j] - motor.damping * measured.dq[j] : commanded.tau[j] - motor.damping * commanded.dq[j];
  }
  model_.step(heat_, torque_);
  judge();
}

void Thermometer::judge() {
  const Hottest now = hottest();
  if (now.total < kCooled) hot_from_ = kHot;
  const bool was_hot = std::exchange(hot_, now.total >= (hot_ ? kCooled : hot_from_));
  if (!was_hot) hot_time_ = 0.0;
  if (!hot_) return;
  hot_time_ += robot_->profile().tick.period;
  // A rest may be held for ever and yet keep a motor above `kCooled`: to wait there any longer is of no use.
  const Thermal& motor = robot_->joints()[static_cast<std::size_t>(now.joint)].motor.thermal;
  const double final = heat_[static_cast<std::size_t>(now.joint)].winding / motor.winding;
  if (hot_time_ < kSettling * motor.winding_time || now.total > final + kSettled || now.total >= kHottest) return;
  hot_ = false;
  hot_from_ = std::clamp(now.total + kHotReserve, kHot, kHottest);
}

}  // namespace baton
