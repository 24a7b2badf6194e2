/// The control loop for any robot: ideal, simulated or real. Each tick it reads the robot, runs the navigator, writes
/// the joint targets, then exchanges requests and answers with the planner.
#pragma once

#include <optional>
#include <vector>

#include "baton/run/operator.hpp"
#include "baton/run/planning.hpp"
#include "baton/run/sink.hpp"

namespace baton {

class Session {
 public:
  struct Parameters {
    Modes modes{};
    StateSource source = StateSource::sensors;  ///< source of the state estimate
    Planning* planning = nullptr;               ///< must use the same modes; null: synchronous, in `step`
    bool hangs = false;                         ///< in a gantry, in the posture at the start (`Navigator::hang`)
  };

  /// All arguments except `start` and `parameters` must outlive this object.
  /// @param start initial posture, standing at rest, in the world frame
  /// @throws InputError the robot lacks the sensors that `source` needs
  Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start)
      : Session(model, world, robot, start, Parameters{}) {}
  Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start,
          const Parameters& parameters);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Adds a sink, which must outlive the last step. Sinks are called in the order they were added.
  void add(Sink& sink) { sinks_.push_back(&sink); }

  /// Runs one tick with the given command, or with the operator's.
  /// @throws InputError the robot's reading has vectors of another length than the model
  void step(const Command& command);
  void step(Operator& who) { step(who.decide(view())); }

  /// Drives joints of the arms from outside, or lets go of them, from the next tick on (`Navigator::drive_arms`).
  /// @throws InputError the targets are none of this robot; nothing has changed then
  void drive_arms(const ArmTargets& targets);

  /// Back to the start: from here on the same commands give the same run, bit by bit, as in a new session. Sinks are
  /// removed, as what they hold belongs to the run before: add those of the new run.
  /// @throws std::logic_error the robot cannot be reset; the session is unchanged then
  void reset();

  /// What the operator can see now.
  [[nodiscard]] Operator::View view() const { return {t(), navigator(), truth()}; }

  /// Where it began, in the world frame.
  [[nodiscard]] const Posture& start() const { return start_; }
  [[nodiscard]] double t() const { return static_cast<double>(ticks_) * model_->profile().tick.period; }
  [[nodiscard]] bool resting() const { return navigator_->motion() == nullptr; }
  /// Whether the robot's truth reports a fall, which ends a run but does not steer: the navigator detects falls by
  /// itself (Navigator::guard()). Always false without truth.
  [[nodiscard]] bool fallen() const { return truth() != nullptr && truth()->fallen; }
  [[nodiscard]] const RobotModel& model() const { return *model_; }
  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] const Navigator& navigator() const { return *navigator_; }
  /// Null if the robot has none.
  [[nodiscard]] const Truth* truth() const { return robot_->truth(); }

 private:
  /// Passes on the planner's answer, if ready; posts the next request if one is due and the planner is idle.
  void plan();
  void hand_in();
  void begin();

  const RobotModel* model_;
  const World* world_;
  Robot* robot_;
  Posture start_;
  Gait gait_;
  StateSource source_;
  bool hangs_;
  std::optional<Navigator> navigator_;
  std::optional<DirectPlanning> on_the_spot_;
  Planning* planning_;
  std::vector<Sink*> sinks_;
  long ticks_ = 0;
};

}  // namespace baton
