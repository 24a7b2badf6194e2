/// What the operator asks for, or a part of it, as a verified motion: what is tried, and in which order.
#pragma once

#include "baton/plan/modes.hpp"
#include "baton/plan/request.hpp"

namespace baton {

/// Request → result. Pure and slow; may live on a thread of its own.
class Strategy {
 public:
  /// Robot and world must outlive the object.
  Strategy(const RobotModel& robot, const World& world, Modes modes = {});
  [[nodiscard]] Answer plan(const Request& request);

 private:
  using Outcome = std::variant<std::monostate, PlannedMotion, Refusal>;

  /// @param trail what the motion belongs to or retraces; of a part of a way back, what is left of it afterwards
  [[nodiscard]] Outcome outcome(const Request& request, std::shared_ptr<const Trail>& trail);
  /// What the command asks for, or a part of it.
  [[nodiscard]] Outcome led(const Limits& limits, const Request& request);
  /// The first goal that has a verified motion.
  [[nodiscard]] Outcome resolve(const Limits& limits, const Request& request, GuideResult guided);
  /// The way back, or the part of it that can be taken; `left` is then what is left of the trail.
  [[nodiscard]] Outcome go_back(const Request& request, std::shared_ptr<const Trail>& left);
  /// The quickest of the ways to rest.
  [[nodiscard]] Outcome stop(const Limits& limits, const Request& request);
  /// A step that catches the robot: the first that gets there in time, or comes nearest to it.
  [[nodiscard]] Outcome catch_step(const Request& request);
  /// The quickest motion to any of these goals; a foot in the air may also land sooner than it was to.
  [[nodiscard]] Outcome quickest(const Limits& limits, const std::vector<Goal>& goals, const Request& request);
  /// To rest at a rest on the trail.
  [[nodiscard]] Outcome halt(const Request& request);
  /// A motion that goes a part of the way, as far as that is found in a few tries and worth it.
  /// @param against what speaks against the whole
  [[nodiscard]] std::optional<PlannedMotion> shrunk(const Limits& limits, const Request& request,
                                                    const Refusal& against);
  /// Whether the guided part comes anywhere by it.
  [[nodiscard]] bool worth(const Posture& from, const Motion& motion) const;
  /// The first of these goals that has a verified motion; else what speaks against the first.
  [[nodiscard]] PlanResult first_of(const Limits& limits, const std::vector<Goal>& goals, const Request& request);
  /// What speaks against lifting a foot, while the other stands on an edge.
  [[nodiscard]] static std::optional<Refusal> no_stance(const Motion& motion, const Request& request);
  /// What speaks against putting down, from there, a foot that `motion` leaves in the air; none: it can be put down.
  [[nodiscard]] std::optional<Refusal> no_landing(const Motion& motion, const GuideContext& context);

  const RobotModel* robot_;
  Modes modes_;
  Guide guide_;
  Planner planner_;
  Limits normal_;
  Limits uneven_ground_;
  Limits push_recovery_;
};

}  // namespace baton
