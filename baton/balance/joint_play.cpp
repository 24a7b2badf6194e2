#include "baton/balance/joint_play.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kLoaded = 0.001;       ///< torque that does not move a motor within its play [stall torque]
constexpr double kAssumed = 4e-3;       ///< play that motors cross, until it is known [rad]
constexpr double kCrosses = 0.3;        ///< change of a motor's place in a tick from which it is crossing [play]
constexpr int kAtEnds = 2;              ///< time after which no motor is crossing any more [ticks]
constexpr double kStandsStill = 0.1;    ///< load from which a sole stands still [total load]
constexpr double kCarry = 0.5;          ///< load from which the legs carry the robot, share of the weight
constexpr double kUsualMove = 2.0;      ///< displacement of a sole per play, in a usual double support [COM height/rad]
constexpr double kPrior = 0.1;          ///< weight of the prior, no play [usual double supports]
constexpr double kMostTrust = 60.0;     ///< largest weight of all that was seen [usual double supports]
constexpr double kLeast = 5e-4;         ///< less cannot be told from soles that give [rad]
constexpr double kLargestPlay = 0.02;   ///< [rad]
constexpr double kLeastInertia = 1e-6;  ///< of a motor, reflected to its joint [kg·m²]
constexpr double kDifference = 1e-3;    ///< for the derivative [rad]

/// Weight of a usual double support [m²/rad²].
double usual_weight(const RobotModel& robot) {
  return std::pow(kUsualMove * robot.profile().stance.com_height, 2);
}

}  // namespace

JointPlay::JointPlay(const RobotModel& robot)
    : robot_(&robot),
      kinematics_(robot),
      configuration_(VecX::Zero(robot.nv() + 1)),
      speed_(VecX::Zero(robot.nv() - 6)),
      latest_{speed_, speed_},
      begin_(latest_),
      end_(latest_),
      trust_(kPrior * usual_weight(robot)) {
  configuration_[3] = 1.0;
  for (const Side side : kSides) {
    for (const int dof : robot.dofs_to(robot.foot_body(side))) {
      if (dof >= 6) legs_.push_back(dof - 6);
    }
  }
}

void JointPlay::correct(VecX& q, const VecX& torque, const SoleContact& contact, const BySide<bool>& planned) {
  if (torque.size() != q.size()) {
    stood_ = begun_ = false;
    return;
  }
  const BySide<double>& load = contact.load();
  const double total = load.left + load.right;
  const bool touch = contact.touch().left && contact.touch().right && total > kCarry * robot_->mass() * kGravity;
  const bool stand =
      planned.left && planned.right && touch && (stood_ || std::min(load.left, load.right) > kStandsStill * total);
  settled_ = cross(torque) ? 0 : std::min(settled_ + 1, kAtEnds);
  latest_.q = q;
  if (!stand && begun_) learn();
  begun_ = begun_ && stand;
  if (stand && settled_ >= kAtEnds) {
    if (!begun_) begin_ = latest_;
    begun_ = true;
    end_ = latest_;
  }
  stood_ = stand;
  q -= estimate() * latest_.side;
}

bool JointPlay::cross(const VecX& torque) {
  const double period = robot_->profile().tick.period;
  const double play = estimate() > 0.0 ? estimate() : kAssumed;
  bool crosses = false;
  for (Eigen::Index j = 0; j < torque.size(); ++j) {
    const double still = kLoaded * robot_->joints()[static_cast<std::size_t>(j)].motor.stall;
    const double drives = torque[j] - std::clamp(torque[j], -still, still);
    double& side = latest_.side[j];
    const bool at_end = drives > 0.0 ? side >= 1.0 : side <= -1.0;
    if (!std::isfinite(drives) || drives == 0.0 || at_end) {
      speed_[j] = 0.0;
      continue;
    }
    const double before = speed_[j];
    speed_[j] += drives / std::max(robot_->mj().dof_armature[6 + j], kLeastInertia) * period;
    const double moved = side + 0.5 * (before + speed_[j]) * period / play;
    const double then = std::clamp(moved, -1.0, 1.0);
    if (moved != then) speed_[j] = 0.0;
    crosses =
        crosses || (std::abs(then - side) > kCrosses && std::ranges::find(legs_, static_cast<int>(j)) != legs_.end());
    side = then;
  }
  return crosses;
}

double JointPlay::estimate() const {
  return play_ < kLeast ? 0.0 : play_;
}

void JointPlay::learn() {
  // Least squares, recursive, with a memory that fades.
  const Vec3 off = moved(play_);
  const Vec3 by_play = (moved(play_ + kDifference) - off) / kDifference;
  if (!(off.norm() <= kLargestPlay * by_play.norm())) return;  // the soles did not stand still
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
  return right_from_left(end_) - before;
}

}  // namespace baton
