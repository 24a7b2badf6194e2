/// The one loop for every robot, ideal, simulated or real. Each tick it reads the robot, runs the navigator, writes the
/// joint targets, and then exchanges requests and answers with the planner.
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
    StateSource source = StateSource::sensors;  ///< where the robot's state comes from
    Planning* planning = nullptr;               ///< by the same modes; null: on the spot, within the tick
  };

  /// All arguments but the posture must outlive the object.
  /// @param start posture that the robot stands in, at rest, in the world
  /// @throws InputError the robot has not the sensors that its state is to come from
  Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start)
      : Session(model, world, robot, start, Parameters{}) {}
  Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start,
          const Parameters& parameters);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Adds a sink, which must outlive the last step. Sinks are called in the order in which they were added.
  void add(Sink& sink) { sinks_.push_back(&sink); }

  /// Runs one tick, with this command or with the one that the operator decides on.
  void step(const Command& command);
  void step(Operator& who) { step(who.decide(view())); }

  /// Back to the start: from here on the same commands give the same run, bit by bit, as in a new session. Sinks stay.
  /// @throws std::logic_error the robot cannot be reset; the session is unchanged then
  void reset();

  /// What an operator may see now.
  [[nodiscard]] Operator::View view() const { return {t(), navigator(), truth()}; }

  [[nodiscard]] double t() const { return static_cast<double>(ticks_) * model_->profile().tick.period; }
  [[nodiscard]] bool resting() const { return navigator_->motion() == nullptr; }
  /// Whether the robot has fallen, by its truth. Without truth always false: see Navigator::guard().
  [[nodiscard]] bool fallen() const { return truth() != nullptr && truth()->fallen; }
  [[nodiscard]] const RobotModel& model() const { return *model_; }
  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] const Navigator& navigator() const { return *navigator_; }
  /// Null if the robot has none.
  [[nodiscard]] const Truth* truth() const { return robot_->truth(); }

 private:
  /// Hands in the planner's answer, if there is one; posts the request that is due, if the planner is free.
  void plan();
  void hand_in();
  void begin();

  const RobotModel* model_;
  const World* world_;
  Robot* robot_;
  Posture start_;
  Gait gait_;
  StateSource source_;
  std::optional<Navigator> navigator_;
  std::optional<DirectPlanning> on_the_spot_;
  Planning* planning_;
  std::vector<Sink*> sinks_;
  long ticks_ = 0;
};

}  // namespace baton
