#include "baton/balance/state.hpp"

#include <stdexcept>

namespace baton {

Estimator::Estimator(const RobotModel& robot)
    : robot_(&robot), kinematics_(robot), jacobian_(3, robot.nv()), dq_(VecX::Zero(robot.nv())) {
  state_.q = VecX::Zero(robot.nq());
}

const State& Estimator::update(const Measurement& measurement, const Pose& anchor, const Kinematics* known) {
  if (!measurement.root) throw std::invalid_argument("Estimator: the measurement has no root pose");
  state_.age = measurement.age;
  const Pose to_plan = anchor.inverse();
  set_root(state_.q, to_plan * measurement.root->pose);
  state_.q.tail(robot_->nv() - 6) = measurement.q;
  dq_.head<3>() = to_plan.R * measurement.root->velocity;
  dq_.segment<3>(3) = measurement.root->rate;
  dq_.tail(robot_->nv() - 6) = measurement.dq;
  if (known != nullptr) {
    kinematics_.set_moved(*known, to_plan * Pose{measurement.root->pose.p, Mat3::Identity()}, state_.q);
  } else {
    kinematics_.set(state_.q);
  }
  state_.com = kinematics_.com();
  kinematics_.com_jacobian(jacobian_);
  state_.dcom.noalias() = jacobian_ * dq_;
  state_.trunk = kinematics_.trunk().R;
  kinematics_.rotation_jacobian(robot_->trunk_body(), jacobian_);
  state_.trunk_rate.noalias() = jacobian_ * dq_;
  for (const Side side : kSides) {
    state_.sole[side] = kinematics_.sole(side);
    const Mat3& R = state_.sole[side].R;
    state_.force[side] = {R * measurement.sole[side].force, R * measurement.sole[side].moment};
  }
  return state_;
}

Pose anchor_correction(const BySide<Pose>& planned, const BySide<Pose>& measured, const BySide<bool>& contact) {
  // By their attitudes, not by the line between them: zero errors of the encoders displace a sole by a millimetre,
  // which turns that line by a degree, but the soles by much less.
  const auto yaw = [&](Side side) { return yaw_of(measured[side].R * planned[side].R.transpose()); };
  const Side first = contact.left ? Side::left : Side::right;
  Pose correction;
  correction.R = rotation_z(mean_yaw(yaw(first), yaw(contact.right ? Side::right : first)));
  Vec3 offset = Vec3::Zero();
  double soles = 0.0;
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    offset += measured[side].p - correction.R * planned[side].p;
    soles += 1.0;
  }
  correction.p = offset / soles;
  return correction;
}

}  // namespace baton
