/// Which motions are tried, and in which order, to fulfil a request wholly or in part.
#pragma once

#include "baton/plan/modes.hpp"
#include "baton/plan/request.hpp"

namespace baton {

/// Request → answer. A pure function that takes milliseconds and may run on a separate thread.
class Strategy {
 public:
  /// `robot` and `world` must outlive this object.
  Strategy(const RobotModel& robot, const World& world, Modes modes = {});
  [[nodiscard]] Answer plan(const Request& request);

 private:
  using Outcome = std::variant<std::monostate, PlannedMotion, Refusal>;

  [[nodiscard]] Answer attempt(const Request& request, const Intent& intent);
  [[nodiscard]] Answer attempt_capture(Request request, const Catch& capture);
  /// On uneven ground, tries a larger ZMP margin first.
  [[nodiscard]] Outcome follow_or_stop(const Request& request, bool stops);
  /// Follows the command, wholly or in part.
  [[nodiscard]] Outcome follow(const Limits& limits, const Request& request);
  /// Plans the first of the guide's goals that has a verified motion.
  [[nodiscard]] Outcome resolve(const Limits& limits, const Request& request, GuideResult guided);
  /// Retraces the trail, or the feasible part of it; `remaining` is then set.
  [[nodiscard]] Outcome go_back(const Request& request, std::shared_ptr<const Trail>& remaining);
  /// Finds the quickest motion to rest on both feet.
  [[nodiscard]] Outcome stop(Limits limits, const Request& request);
  /// A capture step: the first that arrives in time, or else the one that comes closest.
  [[nodiscard]] Outcome catch_step(const Request& request, const Catch& capture);
  /// The quickest motion to any of the goals; a foot in the air may also land earlier than planned.
  [[nodiscard]] Outcome quickest(const Limits& limits, const std::vector<Goal>& goals, const Request& request);
  /// Stands straighter; nothing if no motion leads to a cooler rest.
  [[nodiscard]] Outcome cool(const Request& request);
  /// The arms alone: as far as they are driven, or until they come too close to something; both, or one of them.
  [[nodiscard]] Outcome move_arms(const Request& request);
  /// Stops at a planned rest on the trail.
  [[nodiscard]] Outcome halt(const Request& request, const TrailRest& rest);
  /// A motion that goes part of the way to a refused target, if one worth executing is found in a few tries.
  /// @param against refusal of the whole target
  [[nodiscard]] std::optional<PlannedMotion> shrunk(const Limits& limits, const Request& request, const Target& whole,
                                                    const Refusal& against);
  /// For a refused trunk that is to go ahead or back: a closing step, if the stance is longer than strides
  /// (`Guide::closing_steps`).
  [[nodiscard]] std::optional<PlannedMotion> closing_step(const Request& request, const Refusal& against);
  /// Whether the motion moves the guided part far enough to be worth executing.
  [[nodiscard]] bool worth(const Posture& from, const Motion& motion) const;
  /// The first goal with a verified motion; else the refusal of the first goal.
  [[nodiscard]] PlanResult first_of(const Limits& limits, const std::vector<Goal>& goals, const Request& request);
  /// Why a foot cannot lift off while the other stands on an edge.
  [[nodiscard]] static std::optional<Refusal> no_stance(const Motion& motion, const Request& request);
  /// Why a foot that `motion` leaves in the air could not land from there; none: it can.
  [[nodiscard]] std::optional<Refusal> no_landing(const Motion& motion, const GuideContext& context);
  /// Why the motors would get too hot where `motion` rests on both feet; none: the robot can stay there for ever, or
  /// stand straighter from there once it is hot.
  [[nodiscard]] std::optional<Refusal> no_cooling(const Motion& motion, const GuideContext& context);
  /// A motion from a rest to one that can be held for ever.
  [[nodiscard]] std::optional<PlannedMotion> straightened(const Limits& limits, const Posture& rest,
                                                          const GuideContext& context);

  const RobotModel* robot_;
  Modes modes_;
  Guide guide_;
  Planner planner_;
  Limits normal_;
  Limits uneven_ground_;
  Limits push_recovery_;
};

}  // namespace baton
