/// A motion: contact phases with a centre-of-mass path, and the joint paths that were verified.
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

/// A stretch of a motion during which the same soles stand.
struct ContactPhase {
  int ticks = 0;
  BySide<bool> contact{true, true};
};

/// What the robot is told at one tick: where its joints shall be when the tick ends. Angles before any folding.
struct JointTarget {
  VecX q;                            ///< joint angles (n) [rad]
  VecX dq;                           ///< [rad/s]
  VecX ddq;                          ///< [rad/s²]
  VecX tau;                          ///< feed-forward torque at the joint, motor damping included (n) [N·m]
  BySide<bool> contact{true, true};  ///< which soles are meant to stand
  VecX shift;  ///< what balance adds to the angles, on ground that is not as planned; empty: nothing [rad]
};

/// Planned state at one tick: what is interpolated, followed and shown.
struct MotionSample {
  VecX q;      ///< configuration (nq)
  VecX dq;     ///< (nv)
  VecX ddq;    ///< (nv)
  VecX force;  ///< generalised forces of inverse dynamics without contact (nv)
  Vec3 com = Vec3::Zero();
  Vec3 dcom = Vec3::Zero();
  Vec2 zmp = Vec2::Zero();  ///< of the whole body, on the plane of the lower supporting sole [m]
  double zmp_height = 0.0;  ///< that plane's height [m]
  /// Where the ZMP may be commanded, on that plane: the support polygon less the margin for feedback. Ticks share it.
  std::shared_ptr<const ConvexPolygon> zmp_region;
  BySide<Pose> sole;
  BySide<bool> contact{true, true};
};

/// The way of a swing foot.
struct SwingArc {
  Pose lift_off;        ///< where it left the ground, or was in the air at rest
  double apex_t = 0.0;  ///< when it is highest, from the start of the motion [s]
  double apex = 0.0;    ///< how high that is [m]
};

/// A whole motion from the posture it was planned at to rest: a candidate, until the verifier has made a
/// `VerifiedMotion` of it.
struct Motion {
  double period = 0.0;  ///< of a tick [s]
  Goal goal;
  VecX dq0;                                 ///< velocity with which the first sample is reached (nv)
  BySide<bool> contact_before{true, true};  ///< which soles stood until then
  std::vector<ContactPhase> phases;
  ComPath com;
  std::vector<MotionSample> samples;  ///< one a tick, both ends included
  Posture end;                        ///< at rest
  MotionSample rest;                  ///< the sample of every tick after the end
  SwingArc swing;                     ///< if a foot swings
  bool retraces = false;              ///< an executed motion, backwards
  /// Of a way back that is taken in part: the sample at which it leaves the executed motion for the rest it ends at.
  std::optional<int> leaves;

  [[nodiscard]] int ticks() const { return static_cast<int>(samples.size()) - 1; }
  [[nodiscard]] double duration() const { return period * ticks(); }
  /// Sample at which the last phase begins.
  [[nodiscard]] int last_phase() const { return ticks() - phases.back().ticks; }
};

}  // namespace baton
