/// Planning requests of the navigator, and their answers.
#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "baton/guide/guide.hpp"
#include "baton/plan/planned_motion.hpp"
#include "baton/plan/retrace.hpp"

namespace baton {

/// Shortest remaining flight for which a foot in the air is replanned [s].
[[nodiscard]] inline double least_flight(const Profile& profile) {
  return 0.2 * profile.swing.time;
}
/// Inclination of a sole against the plan up to which it may carry the robot alone [rad].
inline constexpr double kFlatSole = 0.1;

/// The command's goal, or a part of it; also puts down a foot whose throttle was released.
struct Follow {
  bool arms = true;  ///< arms follow what drives them from outside; else they come to rest
};
/// Retrace the trail.
struct Retrace {};
/// Return to the initial stance.
struct Home {};
/// Come to rest on both feet as soon as possible.
struct Stop {};
/// While retracing: stop at a planned rest on the path.
struct HaltAt {
  TrailRest rest;
};
/// A capture step after a push.
struct Catch {
  Vec2 by = Vec2::Zero();            ///< foothold adjustment relative to the plan, planning frame [m]
  double dcm_excess = 0.0;           ///< DCM error beyond what ZMP modulation can absorb [m]
  double height = 0.0;               ///< ground height, planning frame [m]; an inclined sole does not tell it
  Vec2 moved{Vec2::Zero()};          ///< foothold adjustment by an earlier capture step [m]
  double gain = 0.0;                 ///< component of that adjustment along the DCM error [m]
  std::optional<double> lands_in{};  ///< time to planned touchdown of a foot in the air [s]
};

/// With hot motors: stand straighter, above the middle of the feet.
struct Cool {};

/// The arms follow what drives them from outside; all else stays where it rests, or goes where it was to go anyway.
struct MoveArms {};

/// What a motion is for.
using Intent = std::variant<Follow, Retrace, Home, Stop, HaltAt, Catch, Cool, MoveArms>;

/// Rise of a winding's temperature from which the robot goes on no more before it has cooled down [permitted rise].
inline constexpr double kHot = 0.8;

/// Whether this is a stop or a halt.
[[nodiscard]] inline bool stops(const Intent& intent) {
  return std::holds_alternative<Stop>(intent) || std::holds_alternative<HaltAt>(intent);
}

/// The intent of an operator's command.
[[nodiscard]] Intent intent_of(const Command& command);

/// Initial state for planning: the planned state at the take-over, and the motors' heat when the request was made.
struct Start {
  Posture posture;       ///< planning frame; may be moving
  GuideContext context;  ///< what goals are relative to
  /// From rest: the last executed trail. On the way: the trail that the motion to be replaced belongs to, or retraces.
  /// May be null.
  std::shared_ptr<const Trail> trail{};
  int sample = -1;  ///< sample at which the motion under way is replaced; −1: from rest
};

/// What the soles tell about the terrain, beyond the map.
struct Terrain {
  /// A stance sole that is inclined, unlike planned. The foot may step but not carry the robot alone.
  struct Inclined {
    Side side = Side::left;
    double angle = 0.0;  ///< [rad]
  };
  std::optional<Inclined> inclined{};
  bool uneven = false;  ///< soles were recently inclined: plan with a larger ZMP margin where possible
};

/// A planning task: everything the answer depends on.
struct Request {
  long at = 0;      ///< tick of the take-over
  Command command;  ///< of the operator
  Start start;
  Terrain terrain{};
  std::shared_ptr<const ArmPath> arms{};  ///< for `Follow` and `MoveArms`; null: nothing drives the arms
  std::shared_ptr<const Goal> goal{};     ///< for `MoveArms`: of the motion that is replaced; null: from rest
  std::vector<Intent> intents{};  ///< tried in order until one has a verified motion; none: what the command asks for
};

/// The answer to a request, for the last intent tried.
struct Answer {
  long at = 0;  ///< tick of the take-over
  Intent intent;
  /// The command answered: the request's, with the intent's recall; centred for a capture step.
  Command command;
  GuideContext context;  ///< what the goal is relative to
  /// Nothing to do, a verified motion, or a refusal.
  std::variant<std::monostate, PlannedMotion, Refusal> outcome;
  /// With a motion: the trail that it belongs to or retraces; for a partial retrace, the remaining trail.
  std::shared_ptr<const Trail> trail;
  /// With a motion in which arms that are driven from outside come to rest: why they cannot follow.
  std::optional<Refusal> arms_rest{};

  [[nodiscard]] const PlannedMotion* planned() const { return std::get_if<PlannedMotion>(&outcome); }
  [[nodiscard]] const Motion* motion() const { return planned() != nullptr ? &*planned()->motion : nullptr; }
  [[nodiscard]] const Refusal* refusal() const { return std::get_if<Refusal>(&outcome); }
  /// The capture step; null for any other intent.
  [[nodiscard]] const Catch* capture() const { return std::get_if<Catch>(&intent); }
};

}  // namespace baton
