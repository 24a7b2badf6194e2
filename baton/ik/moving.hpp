/// Postures on the way of a motion, and the velocities and accelerations of the body parts in them.
#pragma once

#include "baton/model/kinematics.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// The posture at a sample of a motion, with its velocities and accelerations.
[[nodiscard]] Posture passing(const RobotModel& robot, const MotionSample& sample);

/// Velocity and acceleration of a pose, in the frame that the pose is given in.
struct PoseRate {
  Vec3 v = Vec3::Zero();            ///< of the origin [m/s]
  Vec3 a = Vec3::Zero();            ///< of the origin [m/s²]
  Vec3 rate = Vec3::Zero();         ///< angular velocity [rad/s]
  Vec3 rate_change = Vec3::Zero();  ///< angular acceleration [rad/s²]
};

struct PartRates {
  PoseRate trunk;
  BySide<PoseRate> sole;
  BySide<PoseRate> hand;
};

/// Rates of the body parts in a posture, by finite differences; all zero at rest.
[[nodiscard]] PartRates part_rates(Kinematics& kinematics, const Posture& posture);

}  // namespace baton
