/// The way back: an executed motion from rest to rest, run backwards (docs/theory.md §8). Without motor damping the
/// dynamics is symmetric in time: the same accelerations, contact forces and ZMP, opposite velocities. The damping is
/// why a load counts |τ| + b|q̇|.
#pragma once

#include <memory>
#include <vector>

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// What is kept of what was executed from one rest to the next: one motion, or several of which each replaced the one
/// before on its way.
struct Trail {
  struct Point {
    VecX q;
    Vec3 com = Vec3::Zero();
    BySide<Pose> sole;
  };
  struct Piece {
    std::shared_ptr<const std::vector<Point>> points;  ///< of the whole motion, one a tick
    std::vector<ContactPhase> phases;                  ///< the same
    Goal goal;                                         ///< where it led
    int ticks = 0;                                     ///< that were executed of it

    [[nodiscard]] int planned() const { return static_cast<int>(points->size()) - 1; }
  };
  Posture start;  ///< where it began, at rest
  std::vector<Piece> pieces;

  [[nodiscard]] int ticks() const;
};

/// A rest on the way: a motion that was replaced when only the COM had still to settle would have ended there, and what
/// leads from it back to the start was verified then.
struct Halt {
  std::size_t piece = 0;  ///< of the trail: the motion that would have ended there
  int passed = 0;         ///< sample of the trail's reverse at which that motion is reached
};

[[nodiscard]] Trail trail_of(const Posture& start, const Motion& motion);

/// The same trail, its last motion replaced by `next` when `ticks` of it were executed.
[[nodiscard]] Trail continued(Trail trail, int ticks, const Motion& next);

/// The rests on the way, from the end of the trail to its start.
[[nodiscard]] std::vector<Halt> halts(const Trail& trail);

/// The way to such a rest.
[[nodiscard]] Trail trail_to(const Trail& trail, const Halt& halt);

/// The same path backwards, to be verified: from where `trail` ends to where it began.
[[nodiscard]] Motion reversed(const RobotModel& robot, const Trail& trail);

/// The phases of the first `ticks` of a motion that has these.
[[nodiscard]] std::vector<ContactPhase> first_phases(const std::vector<ContactPhase>& phases, int ticks);

/// Fills in which soles stand at a motion's samples by its phases: where two meet, the later one counts.
void set_contacts(Motion& motion);

/// Fills in velocities and accelerations of a motion's samples by differences of their configurations; before the first
/// the robot moved with the motion's `dq0`, after the last it rests.
void differentiate(const RobotModel& robot, Motion& motion);

}  // namespace baton
