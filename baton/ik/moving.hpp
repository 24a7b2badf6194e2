/// A robot on the move: the posture at a sample of a motion, and how its parts move there.
#pragma once

#include "baton/model/kinematics.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// The posture that a motion passes through at a sample, with the velocities and accelerations that it has there.
[[nodiscard]] Posture passing(const RobotModel& robot, const MotionSample& sample);

/// How a pose moves: v and a of its origin [m/s], [m/s²], its angular velocity [rad/s] and acceleration [rad/s²], all
/// in the frame that the pose is given in.
struct PoseRate {
  Vec3 v = Vec3::Zero();
  Vec3 a = Vec3::Zero();
  Vec3 rate = Vec3::Zero();
  Vec3 rate_change = Vec3::Zero();
};

struct PartRates {
  PoseRate trunk;
  BySide<PoseRate> sole;
  BySide<PoseRate> hand;
};

/// How the parts move in a posture; all zero at rest.
[[nodiscard]] PartRates part_rates(Kinematics& kinematics, const Posture& posture);

}  // namespace baton
