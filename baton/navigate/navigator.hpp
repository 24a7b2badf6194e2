/// The whole idea in one place: at every tick the robot executes a committed motion, one that was verified whole
/// and ends at rest; only here is it replaced, and only by another verified one.
#pragma once

#include <memory>

#include "baton/balance/odometry.hpp"
#include "baton/balance/stabiliser.hpp"
#include "baton/plan/modes.hpp"
#include "baton/plan/request.hpp"

namespace baton {

/// Whether the robot may be moved. It sees for itself that it falls or is lifted off the ground.
enum class Guard {
  armed,
  lifted,    ///< no sole carries: nothing new is begun until it stands again and the stick is let go of
  fallen,    ///< the plan is cleared and the motors are soft
  stood_up,  ///< after a fall, on its feet and still: armed as soon as the stick is let go of
};

/// What the robot is doing, for traces and people.
enum class Phase { hold, double_support, single_left, single_right, fallen };

[[nodiscard]] constexpr std::string_view to_string(Phase phase) {
  constexpr std::array<std::string_view, 5> names{"hold", "double", "single_left", "single_right", "fallen"};
  return names[static_cast<std::size_t>(phase)];
}

/// What the motion under way is for; traces have the number.
enum class Intent {
  none,     ///< there is no motion
  follow,   ///< it follows the stick, or puts down a foot that was let go of
  retrace,  ///< back along what was done
  home,     ///< to the stance that the robot began in
  stop,     ///< to rest, on the way or on a way back
  capture,  ///< a step that catches the robot
};

class Navigator {
 public:
  /// Robot and world must outlive the object.
  /// @param start posture that the robot stands in, at rest, in the world
  /// @param source where the state of the robot comes from
  /// @throws InputError the robot has not the sensors for it
  Navigator(const RobotModel& robot, const World& world, const Posture& start, Gait gait = Gait::flow,
            StateSource source = StateSource::sensors);

  /// One period of the robot: where its joints shall be when the tick ends. Never waits; throws only if a
  /// perfect state is to be used and the measurement has none.
  const JointTarget& tick(const Measurement& measurement, const Command& command);

  /// What a tick leaves to be done because it takes memory or gives it back: frees what is over, forgets what cannot be
  /// retraced any more, and arms a robot that was stood up after a fall. Called once after each tick, whether the
  /// planner is busy or not.
  void poll();

  /// The planning task that is due now, if one is: when the motion is about to end; on its way, where it can go on or
  /// the stick asks for something else, or to stop; at rest when the operator asks for something new, every 50 ms at
  /// most while that is refused. To be answered by `offer`, before the take-over or else in vain. Called after `poll`,
  /// whenever the planner is free; a call that returns nothing changes nothing.
  [[nodiscard]] std::optional<Request> request();

  /// The task that this command would be now, from where the robot rests next. Not before the first tick.
  [[nodiscard]] Request request_for(const Command& command) const;

  /// Hands in an answer. It is taken over at exactly its tick, or dropped if that has passed.
  void offer(Answer result);

  /// Clears the plan, as after a fall: nothing planned may be executed then, and the motors go soft.
  void fall();

  [[nodiscard]] long now() const { return tick_; }
  [[nodiscard]] Phase phase() const;
  [[nodiscard]] Intent intent() const;
  [[nodiscard]] Guard guard() const { return guard_; }
  /// Whether the DCM is so far off that nothing new is begun until it is back: hysteresis from 0.02 to 0.01 of the
  /// nominal COM height.
  [[nodiscard]] bool disturbed() const { return disturbed_; }
  /// Estimated − planned DCM of this tick, along the axes of the world [m]; soles that slid have taken the plan along.
  [[nodiscard]] const Vec2& dcm_error() const { return dcm_error_; }
  /// Number of the segment under way, counted from 0; −1 in hold.
  [[nodiscard]] long segment() const { return motion_ ? committed_ - 1 : -1; }
  [[nodiscard]] long committed() const { return committed_; }
  /// Of them, steps that were to catch a robot pushed off its way.
  [[nodiscard]] long caught() const { return caught_; }
  /// Whether the motion under way is one of them.
  [[nodiscard]] bool catching() const { return motion_ && catches_; }
  /// How often soles were found to have slid too far from where they were planned for the way back to be kept.
  [[nodiscard]] long slips() const { return slips_; }
  [[nodiscard]] double last_slip() const { return last_slip_; }  ///< how far, the last time [m]
  /// The planned sample of this tick, in the planning frame.
  [[nodiscard]] const MotionSample& sample() const { return *sample_; }
  [[nodiscard]] const State& state() const { return *state_; }
  [[nodiscard]] const Odometry& odometry() const { return odometry_; }
  [[nodiscard]] const Correction& correction() const { return stabiliser_.correction(); }
  [[nodiscard]] const Pose& anchor() const { return anchor_; }
  /// Where the anchor would be if no sole had slid since the robot rested last with the stick let go of.
  [[nodiscard]] const Pose& way() const { return way_; }
  /// The committed motion, or null in hold.
  [[nodiscard]] const Motion* motion() const { return motion_; }
  /// The same, with what is known of it beside.
  [[nodiscard]] const PlannedMotion* planned() const { return planned_ ? &*planned_ : nullptr; }
  [[nodiscard]] const Command& command() const { return command_; }
  /// The newest refusal, while the command that it answered still stands.
  [[nodiscard]] const std::optional<Refusal>& refusal() const { return refusal_; }
  /// The command that the newest refusal answered.
  [[nodiscard]] const Command& refused() const { return refused_; }
  /// Requests whose answer was not there at the take-over.
  [[nodiscard]] long dropped() const { return dropped_; }
  /// Motions that can be retraced.
  [[nodiscard]] std::size_t history() const { return history_.size(); }

 private:
  /// What the measurements of this tick say.
  void watch();
  /// Whether the robot stands, falls, or is lifted.
  void update_guard();
  /// Whether the DCM is off.
  void update_disturbed();
  /// Whether soles have slid.
  void update_slip();
  /// Whether it stands on both feet, still, so that it could be armed.
  [[nodiscard]] bool stands_upright() const;
  /// Whether its COM is where it may rest.
  [[nodiscard]] bool supported() const;
  /// How far the standing soles are from where they were planned, as one move of the planning frame.
  [[nodiscard]] Pose slid() const;
  /// The sole that stands on an edge, or on what the map does not know, while both feet are to stand.
  [[nodiscard]] std::optional<Request::Tilted> tilted() const;
  /// How far soles stand inclined from where they were to.
  void feel_ground();
  /// At rest and on the way back: lays the planning frame on where the soles are, little by little.
  void settle();
  /// Begins anew from where the robot stands, after a fall.
  void begin_anew();
  void end_of_motion();
  /// Commits the answer that is due at this tick, or drops it. @returns whether a motion was committed
  bool take_over();
  /// Swaps the motion in: what it replaces is left in `result`.
  void commit(Answer& result);
  /// Keeps no more of what was executed than there is room for.
  void forget();
  void drop_refusal();
  /// Swaps it in.
  void put_refusal(Refusal& refusal);
  /// Whether the ground has edges where the robot is.
  [[nodiscard]] bool edges_near() const;
  /// Whether the motion under way is to be replaced at its sample `at`.
  [[nodiscard]] bool replaceable(int at) const;
  /// What all tasks of replacing it there have in common.
  [[nodiscard]] Request request_replacing(int at) const;
  /// The task of replacing it there by what the stick asks for.
  [[nodiscard]] Request request_on_the_way(int at) const;
  /// The foot that is in the air there, if one is.
  [[nodiscard]] std::optional<Flight> flight(int at) const;
  /// The rest on the way back that can be stopped at from there: both feet stand until it is passed.
  [[nodiscard]] std::optional<Halt> halt_from(int at) const;
  /// The task of coming to rest from there, if there is one.
  [[nodiscard]] std::optional<Request> request_stopping(int at) const;
  /// Before the foot leaves the ground, which is not to be while the robot is off its way: rest, with both feet down.
  [[nodiscard]] std::optional<Request> request_staying(int at) const;
  /// From there, moving, to anything that ends what is under way: a foot in the air can only land.
  [[nodiscard]] Request request_ending(int at) const;
  /// The task that is due now, if one is.
  [[nodiscard]] std::optional<Request> due() const;
  /// A step that takes the robot's feet to where the DCM goes, if no shift of the ZMP can hold it.
  [[nodiscard]] std::optional<Request> request_catching() const;
  /// What goals are relative to where the robot rests next.
  [[nodiscard]] GuideContext context_at_rest() const;
  /// How far off the robot's place is taken to be: no more than leaves steps past edges [m].
  [[nodiscard]] double unsure() const;
  /// What a trunk that is led by this command makes up for of how far soles slid.
  [[nodiscard]] Pose way_back(const GuideContext& context, const Command& command) const;
  /// Where the motion that ends next comes to rest, or where the robot rests.
  [[nodiscard]] const Posture& rest() const { return motion_ ? motion_->end : posture(); }
  /// Where the robot rests when there is no motion, and the sample of that.
  [[nodiscard]] const Posture& posture() const { return rested_ ? (*rested_)->end : posture_; }
  [[nodiscard]] const MotionSample& held() const { return rested_ ? (*rested_)->rest : held_; }

  const RobotModel* robot_;
  const World* world_;
  Gait gait_;
  Odometry odometry_;
  Estimator estimator_;
  Stabiliser stabiliser_;
  double past_edges_;  ///< room that the longest step past an edge leaves on each side of it [m]

  long tick_ = -1;
  Command command_;
  Pose anchor_;                           ///< planning frame in the world
  Pose way_;                              ///< where it would be if no sole had slid
  std::optional<PlannedMotion> planned_;  ///< the committed motion; none: the robot rests
  const Motion* motion_ = nullptr;        ///< the same
  int index_ = 0;                         ///< sample of it that belongs to this tick
  std::optional<VerifiedMotion> rested_;  ///< the motion that the robot rests after; none: it has begun anew
  Posture posture_;                       ///< where it began
  MotionSample held_;                     ///< the sample of that
  const MotionSample* sample_ = nullptr;  ///< planned, at this tick
  const State* state_ = nullptr;
  JointTarget soft_;  ///< after a fall: nothing is asked of the motors
  Guard guard_ = Guard::armed;
  int guard_ticks_ = 0;    ///< for which what would change it has been so
  double inclined_ = 0.0;  ///< of a sole to the plan, the most of late [rad]
  Vec2 dcm_error_ = Vec2::Zero();
  bool disturbed_ = false;       ///< the DCM is too far from where it should be for anything new
  bool slipped_ = false;         ///< soles stand too far from where they were planned for the way back to be kept
  std::optional<Vec2> catches_;  ///< the motion under way, or the last, is to catch the robot: Request::catches
  long caught_ = 0;              ///< motions of that kind so far
  long slips_ = 0;
  double last_slip_ = 0.0;

  long committed_ = 0;             ///< motions so far
  Side last_step_ = Side::right;   ///< before the motion under way
  BySide<Pose> foothold_;          ///< the same
  GuideContext base_;              ///< what the goal of the motion under way was relative to
  Command motion_for_;             ///< what the motion under way was made for
  Command asked_for_;              ///< what was asked for last since it began
  long asked_at_ = 0;              ///< tick of the last request
  std::optional<Request> asked_;   ///< the request under way
  bool waits_ = false;             ///< for its answer
  bool stop_pressed_ = false;      ///< a stop was pressed since the newest request
  std::optional<Answer> offered_;  ///< the newest answer, to be taken over, or what that left
  bool answered_ = false;          ///< it is to be taken over
  // The tick frees no memory: what is over is kept until the next `poll`.
  std::optional<PlannedMotion> past_motion_;
  std::optional<VerifiedMotion> past_rest_;
  std::optional<Refusal> past_refusal_;
  std::optional<Refusal> refusal_;
  bool refused_at_rest_ = false;
  long dropped_ = 0;
  int late_ = 0;                                       ///< answers in a row that came too late
  std::vector<std::shared_ptr<const Trail>> history_;  ///< from rest to rest, the newest last
  std::shared_ptr<const Trail> retraced_;              ///< by the motion under way
  bool halts_ = false;                                 ///< the motion under way does, at a rest on a way back
  Command refused_;                                    ///< what `refusal_` answers
  Pose refused_at_;                                    ///< anchor then
  long not_before_ = 0;                                ///< tick of the next request from rest, after a refusal
};

}  // namespace baton
