/// Retrace: an executed rest-to-rest motion, reversed in time (docs/theory.md §8). Without motor damping the dynamics
/// is time-symmetric: same accelerations, contact forces and ZMP, opposite velocities. To stay valid with damping,
/// torque checks use |τ| + b|q̇|.
#pragma once

#include <memory>
#include <vector>

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Record of what was executed from one rest to the next: one motion, or several that each replaced its predecessor on
/// the way.
struct Trail {
  struct Point {
    VecX q;
    Vec3 com = Vec3::Zero();
    BySide<Pose> sole;
  };
  struct Piece {
    std::shared_ptr<const std::vector<Point>> points;  ///< one per tick; of the whole motion, or as far as executed
    std::vector<ContactPhase> phases;                  ///< of the whole motion
    Goal goal;                                         ///< goal of the motion
    int ticks = 0;                                     ///< executed ticks

    [[nodiscard]] int planned() const { return static_cast<int>(points->size()) - 1; }
  };
  Posture start;  ///< start, at rest
  std::vector<Piece> pieces;

  [[nodiscard]] int ticks() const;
};

/// A planned rest on a trail: the end of a motion that was replaced while only its COM had yet to settle. The path from
/// there back to the start was verified with that motion.
struct TrailRest {
  std::size_t piece = 0;  ///< index of the motion that would have ended there
  int passed = 0;         ///< index of the sample in the reversed trail at which it enters that motion
};

[[nodiscard]] Trail trail_of(const Posture& start, const Motion& motion);

/// The trail continued: `next` replaced its last motion after `ticks`.
[[nodiscard]] Trail continued(Trail trail, int ticks, const Motion& next);

/// Planned rests on the trail, from its end to its start.
[[nodiscard]] std::vector<TrailRest> rests_on(const Trail& trail);

/// The trail that ends at such a rest.
[[nodiscard]] Trail trail_to(const Trail& trail, const TrailRest& halt);

/// The trail reversed, from its end to its start; not yet verified.
[[nodiscard]] Motion reversed(const RobotModel& robot, const Trail& trail);

/// The phases of a motion's first `ticks`.
[[nodiscard]] std::vector<ContactPhase> first_phases(const std::vector<ContactPhase>& phases, int ticks);

/// Sets the stance soles of a motion's samples from its phases; at a boundary the later phase counts.
void set_contacts(Motion& motion);

/// Sets velocities and accelerations of a motion's samples by finite differences. The velocity before the first sample
/// is the motion's `dq0`; after the last the robot is at rest.
void differentiate(const RobotModel& robot, Motion& motion);

}  // namespace baton
