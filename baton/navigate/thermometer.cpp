#include "baton/navigate/thermometer.hpp"

#include <cmath>

#include "baton/plan/request.hpp"

namespace baton {
namespace {

constexpr double kCooled = 0.7;  ///< rise below which the robot goes on [permitted rise]
constexpr double kTorque = 1.5;  ///< largest motor torque, as currents tell it [stall torque]

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
  hot_ = hottest().total >= (hot_ ? kCooled : kHot);
}

}  // namespace baton
