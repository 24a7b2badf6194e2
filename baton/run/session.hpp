/// A run: the one loop for every robot, be it ideal, simulated or real. Tick by tick it reads the robot, lets the
/// navigator decide, writes the joint targets, and sees to the planning.
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

  /// All that is given must outlive the object.
  /// @param start posture that the robot stands in, at rest, in the world
  /// @throws InputError the robot has not the sensors that its state is to come from
  Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start)
      : Session(model, world, robot, start, Parameters{}) {}
  Session(const RobotModel& model, const World& world, Robot& robot, const Posture& start,
          const Parameters& parameters);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// From now on the sink is told of everything, as long as there are steps. Sinks are called in the order in which
  /// they were added.
  void add(Sink& sink) { sinks_.push_back(&sink); }

  /// Lives through one tick with this command, or with the one that the operator decides on.
  void step(const Command& command);
  void step(Operator& who) { step(who.decide(view())); }

  /// Back to the start, with an empty history; what follows is what follows in a new session, bit by bit, if the
  /// operator begins anew as well. Sinks stay.
  /// @throws std::logic_error the robot cannot be put back; nothing has changed then
  void reset();

  /// What an operator may see now.
  [[nodiscard]] Operator::View view() const { return {t(), navigator(), truth()}; }

  [[nodiscard]] double t() const { return static_cast<double>(ticks_) * model_->profile().tick.period; }
  [[nodiscard]] bool resting() const { return navigator_->motion() == nullptr; }
  /// Whether the robot has fallen by its truth. One that has none is never said to have: see Navigator::guard().
  [[nodiscard]] bool fallen() const { return truth() != nullptr && truth()->fallen; }
  [[nodiscard]] const RobotModel& model() const { return *model_; }
  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] const Navigator& navigator() const { return *navigator_; }
  /// Null: the robot has none.
  [[nodiscard]] const Truth* truth() const { return robot_->truth(); }

 private:
  /// Asks the planner for what is due, if it is free, and hands in what it has answered.
  void plan();
  void hand_in();
  /// Begins at the start.
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
