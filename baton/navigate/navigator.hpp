/// The whole idea in one place: at every tick the robot executes a committed motion, one that was verified whole
/// and ends at rest; only here is it replaced, and only by another verified one.
#pragma once

#include <memory>

#include "baton/balance/stabiliser.hpp"
#include "baton/guide/guide.hpp"
#include "baton/plan/planner.hpp"

namespace baton {

/// What happens to a goal that cannot be verified.
enum class OnLimit {
  discard,  ///< the command is refused
  shrink,   ///< the goal comes nearer, along its direction, until it can
};

struct Modes {
  DurationRule duration = DurationRule::paper;
  OnLimit on_limit = OnLimit::shrink;
};

/// A planning task: everything that the answer depends on.
struct Problem {
  long take_over = 0;  ///< tick at which the answer would begin
  Command command;
  GuideContext context;
  std::shared_ptr<const Trail> trail;  ///< the executed motion that is next to be retraced; null: there is none
};

/// The answer: nothing was asked for, a verified motion, or why there is none.
struct PlanningResult {
  long take_over = 0;
  Command command;
  Pose anchor;
  std::variant<std::monostate, Motion, Refusal> outcome;
};

/// Problem → result. Pure and slow; may live on a thread of its own.
class Planning {
 public:
  /// Robot and world must outlive the object.
  Planning(const RobotModel& robot, const World& world, Modes modes = {});
  [[nodiscard]] PlanningResult plan(const Problem& problem);

 private:
  using Outcome = std::variant<std::monostate, Motion, Refusal>;

  [[nodiscard]] Outcome resolve(const GuideContext& context, const Command& command);
  [[nodiscard]] Outcome go_back(const Problem& problem);
  /// A motion that goes a part of the way, as far as that is found in a few tries and worth it.
  [[nodiscard]] std::optional<Motion> shrunk(const Problem& problem);
  /// Whether the guided part comes anywhere by it.
  [[nodiscard]] bool worth(const Posture& from, const Motion& motion) const;
  /// The first of these goals that has a verified motion; else what speaks against the first.
  [[nodiscard]] PlanResult first_of(const std::vector<Goal>& goals, const GuideContext& context);
  /// Whether the foot that `motion` leaves in the air could be put down from there.
  [[nodiscard]] bool can_land(const Motion& motion, const GuideContext& context);

  const RobotModel* robot_;
  Modes modes_;
  Guide guide_;
  Planner planner_;
};

/// What the robot is doing, for traces and people.
enum class Phase { hold, double_support, single_left, single_right, fallen };

[[nodiscard]] constexpr std::string_view to_string(Phase phase) {
  constexpr std::array<std::string_view, 5> names{"hold", "double", "single_left", "single_right", "fallen"};
  return names[static_cast<std::size_t>(phase)];
}

class Navigator {
 public:
  /// @param start posture that the robot stands in, at rest, in the world
  Navigator(const RobotModel& robot, const Posture& start);

  /// One period of the robot: where its joints shall be when the tick ends. Never waits, never throws once the
  /// measurements have a root pose.
  const JointTarget& tick(const Measurement& measurement, const Command& command);

  /// The planning task that is due now, if one is: when the segment is about to end, or at rest when the operator
  /// asks for something new, every 50 ms at most while that is refused. To be answered by `offer`, before the take-over
  /// or else in vain.
  [[nodiscard]] std::optional<Problem> request();

  /// The task that this command would be now, from where the robot rests next. Not before the first tick.
  [[nodiscard]] Problem problem(const Command& command) const;

  /// Hands in an answer. It is taken over at exactly its tick, or dropped if that has passed.
  void offer(PlanningResult result);

  /// Clears the plan after a fall: nothing planned may ever be executed then.
  void fall();

  [[nodiscard]] long now() const { return tick_; }
  [[nodiscard]] Phase phase() const;
  /// Number of the segment under way, counted from 0; −1 in hold.
  [[nodiscard]] long segment() const { return motion_ ? committed_ - 1 : -1; }
  [[nodiscard]] long committed() const { return committed_; }
  /// The planned sample of this tick, in the planning frame.
  [[nodiscard]] const MotionSample& sample() const { return *sample_; }
  [[nodiscard]] const State& state() const { return *state_; }
  [[nodiscard]] const Correction& correction() const { return stabiliser_.correction(); }
  [[nodiscard]] const Pose& anchor() const { return anchor_; }
  /// The committed motion, or null in hold.
  [[nodiscard]] const Motion* motion() const { return motion_ ? &*motion_ : nullptr; }
  [[nodiscard]] const Command& command() const { return command_; }
  /// The newest refusal, while the command that it answered still stands.
  [[nodiscard]] const std::optional<Refusal>& refusal() const { return refusal_; }
  /// Different commands refused since the last motion.
  [[nodiscard]] int refused_in_a_row() const { return refused_in_a_row_; }
  /// Motions that can be retraced.
  [[nodiscard]] std::size_t history() const { return history_.size(); }

 private:
  void end_of_motion();
  void take_over();
  void commit(Motion motion, const Pose& anchor);
  /// Where the motion that ends next comes to rest, or where the robot rests.
  [[nodiscard]] const Posture& rest() const { return motion_ ? motion_->end : posture_; }

  const RobotModel* robot_;
  Estimator estimator_;
  Stabiliser stabiliser_;

  long tick_ = -1;
  Command command_;
  Pose anchor_;                           ///< planning frame in the world
  std::optional<Motion> motion_;          ///< the committed motion; none: the robot rests
  int index_ = 0;                         ///< sample of it that belongs to this tick
  Posture posture_;                       ///< where the robot rests when no motion is left
  MotionSample held_;                     ///< its sample
  const MotionSample* sample_ = nullptr;  ///< planned, at this tick
  const State* state_ = nullptr;
  JointTarget soft_;  ///< after a fall: nothing is asked of the motors
  bool fallen_ = false;

  long committed_ = 0;  ///< motions so far
  Side last_step_ = Side::right;
  BySide<Pose> foothold_;
  std::optional<Problem> asked_;           ///< the request under way
  std::optional<PlanningResult> offered_;  ///< its answer, to be taken over
  std::optional<Refusal> refusal_;
  int refused_in_a_row_ = 0;
  std::vector<std::shared_ptr<const Trail>> history_;  ///< from rest to rest, the newest last
  Command refused_;                                    ///< what `refusal_` answers
  Pose refused_at_;                                    ///< anchor then
  long not_before_ = 0;                                ///< tick of the next request from rest, after a refusal
};

}  // namespace baton
