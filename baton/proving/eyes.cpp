#include "baton/proving/eyes.hpp"

#include <stdexcept>

namespace baton {

Eyes::Eyes(const RobotModel& robot, std::uint64_t seed, const Parameters& parameters)
    : parameters_(parameters), random_(seed), kinematics_(robot) {}

Sight Eyes::look(const Operator::View& view) {
  if (view.truth == nullptr) throw std::logic_error("a robot that has no truth cannot be seen from outside");
  std::normal_distribution<double> normal;
  const auto seen = [&](const Vec3& p) -> Vec3 {
    return p + parameters_.error * Vec3(normal(random_), normal(random_), normal(random_));
  };
  kinematics_.set(view.truth->q);
  Sight sight;
  for (const Side side : kSides) {
    const Pose sole = kinematics_.sole(side);
    sight.sole[side] = {seen(sole.p), rotation_z(yaw_of(sole.R) + parameters_.yaw_error * normal(random_))};
  }
  sight.com = seen(kinematics_.com());
  sight.hand = seen(kinematics_.hand(Side::left).p);
  sight.shoulder = seen(kinematics_.shoulder(Side::left));
  sight.trunk_yaw = yaw_of(kinematics_.trunk().R) + parameters_.yaw_error * normal(random_);
  sight.heading = mean_yaw(sight.sole);
  return sight;
}

Sight Eyes::foresee(const Operator::View& view, double within) {
  const Sight now = look(view);
  Sight then = now;
  const double since = view.t - looked_;
  if (last_ && since < within) {
    const double share = parameters_.foresight / since;
    const Vec3 moved = now.com - last_->com;
    then.com += share * moved;
    then.shoulder += share * moved;
    then.hand += share * (now.hand - last_->hand);
    then.trunk_yaw += share * wrap_angle(now.trunk_yaw - last_->trunk_yaw);
  }
  last_ = now;
  looked_ = view.t;
  return then;
}

}  // namespace baton
