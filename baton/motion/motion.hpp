/// A motion: contact phases, COM path, and the whole-body state at every tick.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baton/math/lip.hpp"
#include "baton/math/polygon.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/refusal.hpp"

namespace baton {

/// A phase with constant contacts.
struct ContactPhase {
  int ticks = 0;
  BySide<bool> contact{true, true};
};

/// Joint command for the end of a tick. No torque is folded into the angles yet.
struct JointTarget {
  VecX q;                            ///< planned joint angles (n) [rad]
  VecX dq;                           ///< [rad/s]
  VecX ddq;                          ///< [rad/s²]
  VecX tau;                          ///< feed-forward joint torque, including motor damping (n) [N·m]
  BySide<bool> contact{true, true};  ///< planned contacts
  VecX q_correction;  ///< added to `q` by balance control, for the ground and play of joints; empty: nothing (n) [rad]
};

/// Planned state at one tick.
struct MotionSample {
  VecX q;                    ///< configuration (nq)
  VecX dq;                   ///< (nv)
  VecX ddq;                  ///< (nv)
  VecX force;                ///< generalised forces by inverse dynamics without contact (nv)
  Vec3 com = Vec3::Zero();   ///< [m]
  Vec3 dcom = Vec3::Zero();  ///< [m/s]
  Vec2 zmp = Vec2::Zero();   ///< whole-body ZMP on the plane of the lower sole in contact [m]
  double zmp_height = 0.0;   ///< height of that plane [m]
  /// Region of the commanded ZMP on that plane: the support polygon inset by `zmp_feedback`. Shared between ticks.
  std::shared_ptr<const ConvexPolygon> zmp_region;
  BySide<Pose> sole;
  BySide<bool> contact{true, true};
};

/// Swing trajectory of a foot.
struct SwingArc {
  Pose lift_off;        ///< pose at lift-off, or where it was held in the air at rest
  double apex_t = 0.0;  ///< time of the apex, from the start of the motion [s]
  double apex = 0.0;    ///< height of the apex [m]
};

/// A complete motion from a start posture to rest. A candidate, until the verifier makes it a `VerifiedMotion`.
struct Motion {
  double period = 0.0;  ///< tick length [s]
  Goal goal;
  VecX dq0;                                 ///< velocity on arrival at the first sample (nv)
  BySide<bool> contact_before{true, true};  ///< contacts before the first sample
  Heat heat;                                ///< of the motors at the first sample; empty: cold
  std::vector<ContactPhase> phases;
  ComPath com;
  std::vector<MotionSample> samples;  ///< one for each tick, including both ends
  Posture end;                        ///< final posture, at rest
  MotionSample rest;                  ///< sample that holds after the end
  Hottest held;                       ///< what the motors come to if the robot rests there for ever
  SwingArc swing;                     ///< if a foot swings
  bool retraces = false;              ///< an executed motion in reverse
  /// Partial retrace only: index of the sample after which it departs from the reversed trail to come to rest.
  std::optional<int> leaves;

  [[nodiscard]] int ticks() const { return static_cast<int>(samples.size()) - 1; }
  [[nodiscard]] double duration() const { return period * ticks(); }
  /// Index of the sample at which the last phase begins.
  [[nodiscard]] int last_phase() const { return ticks() - phases.back().ticks; }
};

}  // namespace baton
