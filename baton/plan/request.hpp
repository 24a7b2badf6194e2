/// What the navigator asks of the planner, and the answer.
#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "baton/guide/guide.hpp"
#include "baton/plan/planned_motion.hpp"
#include "baton/plan/retrace.hpp"

namespace baton {

/// Shortest flight of a foot that is replanned in the air [s].
inline constexpr double kLeastFlight = 0.04;
/// Inclination of a sole against the plan up to which it may carry the robot alone [rad].
inline constexpr double kFlatSole = 0.1;

/// The command's goal, or a part of it; also puts down a foot whose throttle was let go of.
struct Follow {};
/// Back along the trail.
struct Retrace {};
/// To the stance that the robot began in.
struct Home {};
/// To rest on both feet, as soon as possible.
struct Stop {};
/// On a way back: to rest at a rest that was planned there.
struct HaltAt {
  Halt rest;
};
/// A capture step, for a robot that was pushed.
struct Catch {
  Vec2 by = Vec2::Zero();            ///< how much farther than planned the foot should land, planning frame [m]
  double dcm_excess = 0.0;           ///< distance of the DCM beyond what a shift of the ZMP can hold [m]
  double height = 0.0;               ///< of the planning frame: an inclined sole does not tell where the ground is [m]
  Vec2 moved{Vec2::Zero()};          ///< what an earlier capture step has already moved the foothold by [m]
  double gain = 0.0;                 ///< the part of that along the error of the DCM [m]
  std::optional<double> lands_in{};  ///< time until a foot that is in the air lands as it was planned to [s]
};

/// What a motion is to do.
using Intent = std::variant<Follow, Retrace, Home, Stop, HaltAt, Catch>;

/// What the operator's command asks for.
[[nodiscard]] Intent intent_of(const Command& command);

/// The state from which the answer is planned: the planned one at the take-over.
struct Start {
  Posture posture;       ///< in the planning frame; may be moving
  GuideContext context;  ///< what goals are relative to
  /// From rest: what was executed last. On the way: what the motion to be replaced belongs to, or retraces. May be
  /// null.
  std::shared_ptr<const Trail> trail{};
  int sample = -1;  ///< of the motion under way, at which it is replaced; −1: from rest
};

/// What the soles tell of the ground, beyond the map.
struct Terrain {
  /// A sole that stands inclined against the plan; the foot may step, but not carry the robot alone.
  struct Inclined {
    Side side = Side::left;
    double angle = 0.0;  ///< [rad]
  };
  std::optional<Inclined> inclined{};
  bool uneven = false;  ///< soles stood inclined of late: the planned ZMP keeps a larger margin, where it can
};

/// A planning task: everything that the answer depends on.
struct Request {
  long at = 0;      ///< tick of the take-over
  Command command;  ///< the operator's
  Start start;
  Terrain terrain{};
  std::vector<Intent> intents{Follow{}};  ///< tried in this order until one has a verified motion
};

/// The answer to a request, for the intent that was tried last.
struct Answer {
  long at = 0;  ///< tick of the take-over
  Intent intent;
  /// The command that it answers: the request's, with the recall that belongs to the intent; centred for a capture
  /// step.
  Command command;
  GuideContext context;  ///< what the goal is relative to
  /// Nothing is to be done, a verified motion, or why there is none.
  std::variant<std::monostate, PlannedMotion, Refusal> outcome;
  /// With a motion: the trail that it belongs to, or retraces; after a part of a way back, what remains of that.
  std::shared_ptr<const Trail> trail;

  [[nodiscard]] const PlannedMotion* planned() const { return std::get_if<PlannedMotion>(&outcome); }
  [[nodiscard]] const Motion* motion() const { return planned() != nullptr ? &*planned()->motion : nullptr; }
  [[nodiscard]] const Refusal* refusal() const { return std::get_if<Refusal>(&outcome); }
  /// How much farther the foot of a capture step is to land; null for any other intent.
  [[nodiscard]] const Catch* capture() const { return std::get_if<Catch>(&intent); }
  /// Whether it brings the robot to rest at once.
  [[nodiscard]] bool stops() const {
    return std::holds_alternative<Stop>(intent) || std::holds_alternative<HaltAt>(intent);
  }
};

}  // namespace baton
