#include "baton/balance/joint_play.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kLoaded = 0.04;      ///< torque from which a motor is at an end of its play [stall torque]
constexpr double kCrossing = 0.12;    ///< time constant of crossing the play [1/ω]
constexpr double kStandsStill = 0.1;  ///< load from which a sole stands still [total load]
constexpr double kUsualMove = 2.0;    ///< displacement of a sole per play, in a usual double support [COM height/rad]
constexpr double kPrior = 2.0;        ///< weight of the prior, no play [usual double supports]
constexpr double kMostTrust = 60.0;   ///< largest weight of all that was seen [usual double supports]
constexpr double kFound = 0.75;       ///< share of the play that is found: a motor's place is uncertain when it crosses
constexpr double kLeast = 5e-4;       ///< less cannot be told from soles that give [rad]
constexpr double kLargestPlay = 0.02;  ///< [rad]
constexpr double kDifference = 1e-3;   ///< for the derivative [rad]

/// Weight of a usual double support [m²/rad²].
double usual_weight(const RobotModel& robot) {
  return std::pow(kUsualMove * robot.profile().stance.com_height, 2);
}

}  // namespace

JointPlay::JointPlay(const RobotModel& robot)
    : robot_(&robot),
      follows_(std::min(1.0, robot.profile().tick.period * robot.omega() / kCrossing)),
      kinematics_(robot),
      configuration_(VecX::Zero(robot.nv() + 1)),
      end_(VecX::Zero(robot.nv() - 6)),
      latest_{end_, end_},
      begin_(latest_),
      trust_(kPrior * usual_weight(robot)) {
  configuration_[3] = 1.0;
}

void JointPlay::correct(VecX& q, const VecX& torque, const SoleContact& contact, const BySide<bool>& planned) {
  if (torque.size() != q.size()) return;
  const BySide<double>& load = contact.load();
  const bool stand =
      planned.left && planned.right && std::min(load.left, load.right) > kStandsStill * (load.left + load.right);
  if (!stand && ticks_ > 1) learn();
  ticks_ = stand ? ticks_ + 1 : 0;
  latest_.q = q;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double loaded = kLoaded * robot_->joints()[static_cast<std::size_t>(j)].motor.stall;
    if (std::abs(torque[j]) > loaded) end_[j] = std::copysign(1.0, torque[j]);
  }
  latest_.side += follows_ * (end_ - latest_.side);
  if (ticks_ == 1) begin_ = latest_;
  q -= estimate() * latest_.side;
}

double JointPlay::estimate() const {
  const double play = std::min(play_ / kFound, kLargestPlay);
  return play < kLeast ? 0.0 : play;
}

void JointPlay::learn() {
  // Least squares, recursive, with a memory that fades.
  const Vec3 off = moved(play_);
  const Vec3 by_play = (moved(play_ + kDifference) - off) / kDifference;
  trust_ = std::min(trust_ + by_play.squaredNorm(), kMostTrust * usual_weight(*robot_));
  play_ = std::clamp(play_ - by_play.dot(off) / trust_, 0.0, kLargestPlay);
}

Vec3 JointPlay::moved(double play) {
  const auto right_from_left = [&](const State& state) {
    configuration_.tail(state.q.size()) = state.q - play * state.side;
    kinematics_.set(configuration_);
    return (kinematics_.sole(Side::left).inverse() * kinematics_.sole(Side::right)).p;
  };
  const Vec3 before = right_from_left(begin_);
  return right_from_left(latest_) - before;
}

}  // namespace baton
