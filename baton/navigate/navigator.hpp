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

/// Contact phase of a tick, for traces.
enum class Phase { hold, double_support, single_left, single_right, fallen };

[[nodiscard]] constexpr std::string_view to_string(Phase phase) {
  constexpr std::array<std::string_view, 5> names{"hold", "double", "single_left", "single_right", "fallen"};
  return names[static_cast<std::size_t>(phase)];
}

/// What the motion under way is for; traces have the number.
enum class Purpose {
  none,     ///< there is no motion
  follow,   ///< it follows the stick, or puts down a foot whose throttle was released
  retrace,  ///< back along what was done
  home,     ///< to the stance that the robot began in
  stop,     ///< to rest, on the way or on a way back
  capture,  ///< a capture step
  cool,     ///< to a straighter posture, in which hot motors cool down
};

[[nodiscard]] constexpr std::string_view to_string(Purpose purpose) {
  constexpr std::array<std::string_view, 7> names{"none", "follow", "retrace", "home", "stop", "capture", "cool"};
  return names[static_cast<std::size_t>(purpose)];
}

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

  /// Says, before the first tick, that the robot hangs in a gantry, in the posture that it starts in: nothing is begun
  /// until it was lowered and stands.
  void hang() { watch_.hang(); }

  /// Joint targets for the end of this tick. Never blocks; throws only with `StateSource::perfect`, if the measurement
  /// has no root pose.
  const JointTarget& tick(const Measurement& measurement, const Command& command);

  /// Work that allocates or frees memory, and is therefore not done in `tick`: frees replaced motions, trims the
  /// history and re-arms the robot once it was stood up after a fall. Call it once after each tick, whether or not the
  /// planner is busy.
  void poll();

  /// The planning request that is due now, if any (`due`). Answer it with `answer` before its take-over tick; a later
  /// answer is dropped. Call it after `poll`, whenever the planner is free; a call that returns nothing changes
  /// nothing.
  [[nodiscard]] std::optional<Request> request();

  /// The request that this command would make now, from the next rest. Requires a previous `tick`.
  [[nodiscard]] Request request_for(const Command& command) const;

  /// Hands in an answer. Its motion begins at exactly the tick of its take-over; a late answer is dropped.
  void answer(Answer answer);

  /// Drives joints of the arms from outside, or lets go of them: from the next motion on, and on the way of the one
  /// under way. Like `poll` it is called between ticks, as it needs memory. While an arm's hand is guided, and during
  /// retraces, capture steps and stops, they do not count for it.
  /// @throws InputError as `ArmTrajectory::continued`; nothing has changed then
  void drive_arms(const ArmTargets& targets);

  /// Events of the latest tick in order, including those of the `poll` before it.
  [[nodiscard]] std::span<const Event> events() const { return events_.list(); }

  [[nodiscard]] long now() const { return tick_; }
  [[nodiscard]] const Command& command() const { return command_; }
  [[nodiscard]] Phase phase() const;
  [[nodiscard]] Purpose purpose() const;
  /// The committed motion, or null in hold.
  [[nodiscard]] const Motion* motion() const { return course_.motion(); }
  /// That motion with the planner's notes; null in hold.
  [[nodiscard]] const PlannedMotion* planned() const;
  /// Number of the segment under way, counted from 0; −1 in hold.
  [[nodiscard]] long segment() const { return motion() != nullptr ? course_.committed() - 1 : -1; }
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

  /// Requires a previous `tick`.
  [[nodiscard]] const State& state() const { return watch_.state(); }
  [[nodiscard]] const Odometry& odometry() const { return watch_.odometry(); }
  [[nodiscard]] Guard guard() const { return watch_.guard(); }
  /// Plausibility of the sensors' readings.
  [[nodiscard]] const SensorCheck& sensors() const { return watch_.sensors(); }
  /// How hot the motors are, and whether the robot waits for them to cool down.
  [[nodiscard]] const Thermometer& thermometer() const { return watch_.thermometer(); }
  /// Whether the DCM error is too large to begin a motion, or a sensor is lost.
  [[nodiscard]] bool disturbed() const { return watch_.disturbed(); }
  /// Estimated − planned DCM, in world axes [m].
  [[nodiscard]] const Vec2& dcm_error() const { return watch_.dcm_error(); }
  /// How often soles slid too far for the way back to be kept, and how far the last time [m].
  [[nodiscard]] long slips() const { return watch_.slips(); }
  [[nodiscard]] double last_slip() const { return watch_.last_slip(); }
  [[nodiscard]] const Correction& correction() const { return stabiliser_.correction(); }

  /// The newest refusal, while the command that it answered still stands; else null.
  [[nodiscard]] const Refusal* refusal() const { return refused_.refusal.get(); }
  /// What drives the arms.
  [[nodiscard]] const ArmTrajectory& arms() const { return arms_; }
  /// Why the arms cannot follow it, or only in part; null: they do.
  [[nodiscard]] const Refusal* arms_refusal() const { return arms_refusal_.get(); }
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
  /// Asks for the arms alone again only after some time.
  void rest_arms();
  /// Notes that the arms follow what drives them; or why they do not, or only in part.
  void note_arms(const std::shared_ptr<const Answer>& answer, const Refusal* why);
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
  JointTarget soft_;  ///< after a fall: zero torque at the measured angles
  long tick_ = -1;
  Command command_;
  Exchange exchange_;
  LastRefusal refused_;
  ArmTrajectory arms_;
  std::shared_ptr<const Refusal> arms_refusal_;
  Retired retired_;
  Events events_;
  /// What events were told of last.
  struct Told {
    bool executing = false;
    Guard guard = Guard::armed;
    bool disturbed = false;
    bool hot = false;
    long slips = 0;
    BySensor<Health> health;
  };
  Told told_;
};

}  // namespace baton
