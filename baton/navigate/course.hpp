/// What is being executed: a committed motion or rest, the sample of this tick, and the planning frame in the world.
#pragma once

#include <memory>
#include <variant>

#include "baton/navigate/retired.hpp"
#include "baton/plan/request.hpp"

namespace baton {

/// The robot holds the posture in which the last motion ended.
struct Resting {};
/// A committed motion is under way.
struct Executing {
  std::shared_ptr<const Answer> answer;  ///< has a motion
};
/// The robot follows the stick, or goes home.
struct Moving : Executing {};
/// The robot retraces a trail.
struct Retracing : Executing {
  std::shared_ptr<const Trail> trail;  ///< null after a slip: no rest on it can be trusted
};
/// While retracing: the robot comes to a planned rest on the trail.
struct Halting : Executing {};
/// The robot comes to rest as soon as possible.
struct Stopping : Executing {};
/// A capture step.
struct Catching : Executing {};

class Course {
 public:
  /// Where the robot rests: posture and its sample, in the planning frame.
  struct Rest {
    std::shared_ptr<const Posture> posture;
    std::shared_ptr<const MotionSample> sample;
  };

  /// The robot must outlive the object.
  Course(const RobotModel& robot, const Posture& start);

  // What a tick does; handles that are given up go to `retired`.

  /// Advances to the next sample; after the last, to rest.
  void advance(Retired& retired);
  /// Executes the answer's motion from its first sample on.
  /// @param trail the one that the motion retraces; else null
  void commit(std::shared_ptr<const Answer> answer, std::shared_ptr<const Trail> trail, Retired& retired);
  /// Drops the motion, as after a fall.
  void drop(Retired& retired);
  /// Accepts a slip that is too large to correct: the slip-free frame becomes the current place.
  /// @param slid displacement of the stance soles, as a displacement of the planning frame
  void accept_slip(const Pose& slid) { slip_free_frame_ = anchor_ * slid; }
  /// At rest with a centred stick: the slip-free frame becomes the planning frame.
  void accept_place() { slip_free_frame_ = anchor_; }
  /// Moves the planning frame gradually to where the soles stand.
  void settle(const Pose& slid);

  // What `Navigator::poll` does.

  /// After a slip, no rest on the trail can be trusted.
  void forget_trail();
  /// Begins anew from the posture in which the robot stands.
  void begin_anew(const Posture& posture);

  [[nodiscard]] const std::variant<Resting, Moving, Retracing, Halting, Stopping, Catching>& state() const {
    return state_;
  }
  template <typename State>
  [[nodiscard]] bool is() const {
    return std::holds_alternative<State>(state_);
  }
  /// The answer whose motion is under way; null at rest.
  [[nodiscard]] const Answer* answer() const { return handle() == nullptr ? nullptr : handle()->get(); }
  /// The motion under way; null at rest.
  [[nodiscard]] const Motion* motion() const { return answer() == nullptr ? nullptr : answer()->motion(); }
  /// Sample of it that belongs to this tick.
  [[nodiscard]] int index() const { return index_; }
  /// The planned sample of this tick, and of the next, in the planning frame.
  [[nodiscard]] const MotionSample& sample() const { return *sample_; }
  [[nodiscard]] const MotionSample& next_sample() const;
  /// The end of the motion under way, or where the robot rests.
  [[nodiscard]] const Posture& rest() const { return motion() != nullptr ? motion()->end : *rest_.posture; }
  /// Planning frame in the world.
  [[nodiscard]] const Pose& anchor() const { return anchor_; }
  /// Where that frame would be if no sole had slid since the robot last rested with a centred stick.
  [[nodiscard]] const Pose& slip_free_frame() const { return slip_free_frame_; }
  /// The foot that stepped last, and where each foot stood last, before the motion under way.
  [[nodiscard]] Side last_step() const { return last_step_; }
  [[nodiscard]] const BySide<Pose>& foothold() const { return foothold_; }
  /// Updates both by the steps of the motion under way, as they will be after it.
  void note_steps(Side& last_step, BySide<Pose>& foothold) const;
  /// Uncertainty of the robot's place for which the newest motion was planned [m].
  [[nodiscard]] double uncertainty() const { return uncertainty_; }
  /// Motions committed so far, and of these the capture steps.
  [[nodiscard]] long committed() const { return committed_; }
  [[nodiscard]] long caught() const { return caught_; }

 private:
  [[nodiscard]] const std::shared_ptr<const Answer>* handle() const;
  /// Releases the motion under way.
  void retire(Retired& retired);

  const RobotModel* robot_;
  std::variant<Resting, Moving, Retracing, Halting, Stopping, Catching> state_;
  int index_ = 0;
  Rest rest_;  ///< the last one
  const MotionSample* sample_;
  Pose anchor_;
  Pose slip_free_frame_;
  Side last_step_ = Side::right;
  BySide<Pose> foothold_;
  double uncertainty_ = 0.0;
  long committed_ = 0;
  long caught_ = 0;
};

}  // namespace baton
