/// What the navigator asks of the planner, and what it is answered.
#pragma once

#include <memory>

#include "baton/guide/guide.hpp"
#include "baton/plan/planned_motion.hpp"
#include "baton/plan/retrace.hpp"

namespace baton {

/// A foot that leaves or meets the ground sooner is not sent elsewhere [s].
inline constexpr double kLeastFlight = 0.04;
/// Inclination to the plan up to which a sole may carry the robot alone [rad].
inline constexpr double kFlatSole = 0.1;

/// A planning task: everything that the answer depends on.
struct Request {
  long take_over = 0;  ///< tick at which the answer would begin
  Command command;
  GuideContext context;
  Posture start;  ///< planned posture at the take-over, in the planning frame; may be moving
  /// From rest, what was executed last, to be retraced next; on the way, what the motion to be replaced belongs to, or
  /// retraces. Null: there is none.
  std::shared_ptr<const Trail> trail{};
  int replaced_at{-1};         ///< sample of the motion under way at which it is replaced; −1: from rest
  std::optional<Halt> halt{};  ///< a rest on the trail, to stop at on the way back
  /// It is pushed and a step is to catch it: how much farther than planned the foot should land [m].
  std::optional<Vec2> catches{};
  /// Then: how much farther off the DCM is than a ZMP can hold [m]; and when a foot that is in the air already lands,
  /// from now on [s], so much farther than was planned for it before it was to catch the robot [m].
  double beyond{0.0};
  std::optional<double> lands{};
  double gains{0.0};
  /// A sole that stands tilted from where it was to, more than the other; it may step, but not carry the robot alone.
  struct Tilted {
    Side side = Side::left;
    double by = 0.0;  ///< [rad]
  };
  std::optional<Tilted> tilted{};
  bool uneven = false;  ///< soles stood inclined of late: the planned ZMP keeps farther inside, where it can
  std::shared_ptr<const Request> otherwise{};  ///< the task instead, where no step catches the robot
};

/// The answer: nothing was asked for, a verified motion, or why there is none.
struct Answer {
  long take_over = 0;
  Command command;
  GuideContext context;
  std::variant<std::monostate, PlannedMotion, Refusal> outcome;
  /// With a motion: what it belongs to from then on, or retraces; with a part of a way back, what is left of that.
  std::shared_ptr<const Trail> trail;
  std::optional<Vec2> catches{};  ///< as in the request
};

}  // namespace baton
