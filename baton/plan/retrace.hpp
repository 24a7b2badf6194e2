/// The way back: an executed motion from rest to rest, run backwards (docs/theory.md §8). Without motor damping the
/// dynamics is symmetric in time: the same accelerations, contact forces and ZMP, opposite velocities. The damping is
/// why a load counts |τ| + b|q̇|.
#pragma once

#include <vector>

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// What is kept of an executed motion.
struct Trail {
  struct Point {
    VecX q;
    Vec3 com = Vec3::Zero();
    BySide<Pose> sole;
  };
  Posture start;  ///< where it began, at rest
  Goal goal;      ///< where it led
  std::vector<ContactPhase> phases;
  std::vector<Point> points;  ///< one a tick
};

[[nodiscard]] Trail trail_of(const Posture& start, const Motion& motion);

/// The same path backwards, to be verified: from where `trail` ends to where it began.
[[nodiscard]] Motion reversed(const RobotModel& robot, const Trail& trail);

/// Fills in velocities and accelerations of a motion's samples by differences of their configurations; before the first
/// the robot moved with `dq0`, after the last it rests.
void differentiate(const RobotModel& robot, const VecX& dq0, Motion& motion);

}  // namespace baton
