/// The whole idea in one place: at every tick the robot executes a committed motion, one that was verified whole
/// and ends at rest; only here is it replaced, and only by another verified one.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "baton/balance/stabiliser.hpp"
#include "baton/navigate/due.hpp"
#include "baton/navigate/event.hpp"

namespace baton {

/// What the robot is doing, for traces and people.
enum class Phase { hold, double_support, single_left, single_right, fallen };

[[nodiscard]] constexpr std::string_view to_string(Phase phase) {
  constexpr std::array<std::string_view, 5> names{"hold", "double", "single_left", "single_right", "fallen"};
  return names[static_cast<std::size_t>(phase)];
}

/// What the motion under way is for; traces have the number.
enum class Purpose {
  none,     ///< there is no motion
  follow,   ///< it follows the stick, or puts down a foot whose throttle was let go of
  retrace,  ///< back along what was done
  home,     ///< to the stance that the robot began in
  stop,     ///< to rest, on the way or on a way back
  capture,  ///< a capture step
};

class Navigator {
 public:
  /// Robot and world must outlive the object.
  /// @param start posture that the robot stands in, at rest, in the world
  /// @param source where the state of the robot comes from
  /// @throws InputError the robot has not the sensors for it
  Navigator(const RobotModel& robot, const World& world, const Posture& start, Gait gait = Gait::flow,
            StateSource source = StateSource::sensors);
  Navigator(const Navigator&) = delete;
  Navigator& operator=(const Navigator&) = delete;

  /// One period of the robot: where its joints shall be when the tick ends. Never waits; throws only if a
  /// perfect state is to be used and the measurement has none.
  const JointTarget& tick(const Measurement& measurement, const Command& command);

  /// What a tick leaves to be done because it takes memory or gives it back: frees what is over, forgets what cannot be
  /// retraced any more, and arms a robot that was stood up after a fall. Called once after each tick, whether the
  /// planner is busy or not.
  void poll();

  /// The planning task that is due now, if one is (`due`). To be answered by `answer`, before the take-over or else in
  /// vain. Called after `poll`, whenever the planner is free; a call that returns nothing changes nothing.
  [[nodiscard]] std::optional<Request> request();

  /// The task that this command would be now, from where the robot rests next. Not before the first tick.
  [[nodiscard]] Request request_for(const Command& command) const;

  /// Hands in an answer. It is taken over at exactly its tick, or dropped if that has passed.
  void answer(Answer answer);

  /// What has happened since the tick before the newest, until the end of the newest, in its order.
  [[nodiscard]] std::span<const Event> events() const { return events_.list(); }

  [[nodiscard]] long now() const { return tick_; }
  [[nodiscard]] const Command& command() const { return command_; }
  [[nodiscard]] Phase phase() const;
  [[nodiscard]] Purpose purpose() const;
  /// The committed motion, or null in hold.
  [[nodiscard]] const Motion* motion() const { return course_.motion(); }
  /// Number of the segment under way, counted from 0; −1 in hold.
  [[nodiscard]] long segment() const { return motion() != nullptr ? course_.committed() - 1 : -1; }
  /// The same, with what is known beside it.
  [[nodiscard]] const PlannedMotion* planned() const;
  /// Motions so far, and of these the capture steps.
  [[nodiscard]] long committed() const { return course_.committed(); }
  [[nodiscard]] long caught() const { return course_.caught(); }
  /// Whether a capture step is under way.
  [[nodiscard]] bool catching() const { return course_.is<Catching>(); }
  /// The planned sample of this tick, in the planning frame.
  [[nodiscard]] const MotionSample& sample() const { return course_.sample(); }
  /// Planning frame in the world; and where it would be if no sole had slid since the robot last rested with a centred
  /// stick.
  [[nodiscard]] const Pose& anchor() const { return course_.anchor(); }
  [[nodiscard]] const Pose& slip_free_frame() const { return course_.slip_free_frame(); }
  /// Trails that can be retraced.
  [[nodiscard]] std::size_t history() const { return history_.size(); }

  /// Not before the first tick.
  [[nodiscard]] const State& state() const { return watch_.state(); }
  [[nodiscard]] const Odometry& odometry() const { return watch_.odometry(); }
  [[nodiscard]] Guard guard() const { return watch_.guard(); }
  /// Whether the DCM is so far off that nothing new is begun, and how far it is (`Watch`).
  [[nodiscard]] bool disturbed() const { return watch_.disturbed(); }
  [[nodiscard]] const Vec2& dcm_error() const { return watch_.dcm_error(); }
  /// How often soles slid too far for the way back to be kept, and how far the last time [m].
  [[nodiscard]] long slips() const { return watch_.slips(); }
  [[nodiscard]] double last_slip() const { return watch_.last_slip(); }
  [[nodiscard]] const Correction& correction() const { return stabiliser_.correction(); }

  /// The newest refusal, while the command that it answered still stands; else null.
  [[nodiscard]] const Refusal* refusal() const { return refused_.refusal.get(); }
  /// The command that the newest refusal answered.
  [[nodiscard]] const Command& refused() const { return refused_.command; }
  /// Requests whose answer was not there at the take-over.
  [[nodiscard]] long dropped() const { return exchange_.dropped; }

 private:
  /// Commits the answer that is due at this tick, or drops it. @returns whether a motion was committed
  bool take_over();
  /// Whether the answer's motion may be executed now.
  [[nodiscard]] bool valid(const Answer& answer) const;
  void commit(std::shared_ptr<const Answer> answer);
  /// Keeps the refusal, until another command is given.
  void refuse(const std::shared_ptr<const Answer>& answer);
  void drop_refusal();
  /// Drops the plan, once the robot has fallen.
  void drop_plan();
  /// Begins anew from where the robot stands, after a fall.
  void begin_anew();
  /// Adds events for what has changed since the events before.
  void tell_changes();
  void tell_end();
  [[nodiscard]] Situation situation() const;

  const RobotModel* robot_;
  const World* world_;
  Gait gait_;
  Watch watch_;
  Course course_;
  History history_;
  Stabiliser stabiliser_;
  JointTarget soft_;  ///< after a fall: nothing is asked of the motors
  long tick_ = -1;
  Command command_;
  Exchange exchange_;
  LastRefusal refused_;
  Retired retired_;
  Events events_;
  /// What events were told of last.
  struct Told {
    bool executing = false;
    Guard guard = Guard::armed;
    bool disturbed = false;
    long slips = 0;
  };
  Told told_;
};

}  // namespace baton
