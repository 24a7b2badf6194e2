#include "baton/proving/arm_policy.hpp"

#include <algorithm>
#include <cmath>

#include "baton/ik/stand.hpp"
#include "baton/math/quintic.hpp"

namespace baton {
namespace {

constexpr double kSwing = 0.6;      ///< largest distance of a target from the joint's home [rad]
constexpr double kPath = 1.5;       ///< time from target to target [s]
constexpr double kPiece = 0.5;      ///< of it that is given at once [s]
constexpr double kPoints = 0.05;    ///< from point to point [s]
constexpr double kAhead = 1.0;      ///< time between when a piece is known and when it begins [s]
constexpr int kTries = 100;         ///< targets that are drawn until one is free
constexpr double kOnTarget = 0.05;  ///< [rad]

}  // namespace

ArmPolicy::ArmPolicy(const RobotModel& robot, std::uint64_t seed)
    : robot_(&robot),
      kinematics_(robot),
      home_(stand(robot, {}, robot.profile().stance.com_height).q),
      dice_(seed),
      began_(kAhead - kPath),
      known_(kAhead) {
  for (const Side side : kSides) {
    for (const int j : robot.arm(side))
      joints_.push_back(j);
  }
  targets_ = released_arms(robot);
  to_.resize(std::ssize(joints_));
  for (std::size_t k = 0; k < joints_.size(); ++k)
    to_[static_cast<Eigen::Index>(k)] = robot.joints()[static_cast<std::size_t>(joints_[k])].home;
  from_ = to_;
}

const ArmTargets* ArmPolicy::next(double t) {
  asked_at_ = t;
  if (joints_.empty() || t < known_ - kAhead - 1e-9) return nullptr;
  if (known_ > began_ + kPath - 1e-9) {
    began_ += kPath;
    from_ = to_;
    // It knows its robot: no path leads through another link, at least while that stands straight.
    int tries = kTries;
    do {
      for (std::size_t k = 0; k < joints_.size(); ++k) {
        const Joint& joint = robot_->joints()[static_cast<std::size_t>(joints_[k])];
        const double margin = 2.0 * robot_->profile().margin.joint;
        const double target = joint.home + kSwing * dice_.axis();
        to_[static_cast<Eigen::Index>(k)] =
            std::max(std::min(target, joint.position.hi - margin), joint.position.lo + margin);
      }
    } while (!is_free() && --tries > 0);
    if (tries == 0) to_ = from_;
  }
  const auto points = static_cast<Eigen::Index>(std::lround(kPiece / kPoints));
  targets_.t.clear();
  targets_.q.resize(points, to_.size());
  for (Eigen::Index i = 0; i < points; ++i) {
    targets_.t.push_back(known_ + kPoints * static_cast<double>(i + 1));
    const double s = smooth_step(targets_.t.back() - began_, kPath).x;
    targets_.q.row(i) = (from_ + s * (to_ - from_)).transpose();
  }
  known_ += kPiece;
  return &targets_;
}

bool ArmPolicy::is_free() {
  VecX q = home_;
  const double margin = 2.0 * robot_->profile().margin.self_collision;
  for (const double s : {0.25, 0.5, 0.75, 1.0}) {
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      q[7 + joints_[k]] = from_[i] + s * (to_[i] - from_[i]);
    }
    kinematics_.set(q);
    if (kinematics_.self_distance(2.0 * margin, nullptr) < margin) return false;
  }
  return true;
}

void ArmPolicy::on_tick(const TickRecord& record) {
  if (record.t != asked_at_ || record.t < kAhead || record.truth == nullptr) return;
  const Command& command = record.navigator.command();
  const Motion* motion = record.navigator.motion();
  for (const Side side : kSides) {
    const bool guided = command.guide == hand(side) && !command.neutral();
    if (guided || (motion != nullptr && motion->goal.hand[side])) continue;
    const std::vector<int>& joints = robot_->arm(side);
    if (joints.empty()) continue;
    ++ticks_;
    const bool all = std::ranges::all_of(joints, [&](int j) {
      return std::abs(record.navigator.arms().at(j, record.t) - record.truth->q[7 + j]) <= kOnTarget;
    });
    if (all) ++on_target_;
  }
}

}  // namespace baton
