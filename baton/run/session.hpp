/// One run: robot, world, navigator, planner and a device, tick by tick.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "baton/input/device.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/proving/dice.hpp"
#include "baton/record/recording.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "baton/run/planning_thread.hpp"

namespace baton {

/// What goes wrong with the planner's answers on their way to the navigator.
struct AnswerFaults {
  double delay = 0.0;      ///< each comes late, by at most this [s]
  double loss = 0.0;       ///< share of answers that never come
  std::uint64_t seed = 0;  ///< of the delays and losses

  [[nodiscard]] bool any() const { return delay > 0.0 || loss > 0.0; }
};

/// Thread CPU time [µs].
[[nodiscard]] double cpu_us();

class Session {
 public:
  enum class On { sim, ideal };

  /// @param start posture that the robot begins in; none: it stands at the world's site `start`
  /// @throws InputError robot and world do not go together
  Session(const RobotModel& robot, const World& world, On on, std::optional<Posture> start = std::nullopt,
          SimulatedRobot::Parameters parameters = {}, Modes modes = {}, StateSource state = StateSource::sensors);

  /// Called with every tick, and with every answer of the planner.
  std::function<void(const TickRecord&)> on_tick;
  std::function<void(const PlanRecord&)> on_plan;
  std::function<void(PlanningEvent)> on_event;

  /// From now on planning has a thread of its own, for a run by the clock on the wall: answers come when they are
  /// ready, and are dropped if that is too late. Without it they come at once, whatever the clock says.
  void plan_on_a_thread();

  /// From now on answers come late or not at all.
  void spoil_answers(const AnswerFaults& faults);

  /// Lives through one tick with this command.
  void step(const Command& command);

  [[nodiscard]] double t() const { return t_; }
  [[nodiscard]] bool fallen() const { return body_->truth().fallen; }
  [[nodiscard]] bool resting() const { return navigator_.motion() == nullptr; }
  [[nodiscard]] const RobotModel& robot() const { return *robot_; }
  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] const Navigator& navigator() const { return navigator_; }
  [[nodiscard]] const Truth& truth() const { return body_->truth(); }
  /// Robot and world in one model, as MJCF text: what is stepped in simulation.
  [[nodiscard]] const std::string& model_text() const { return model_text_; }
  /// The simulated robot; null on `ideal`.
  [[nodiscard]] SimulatedRobot* simulated() { return simulated_; }

 private:
  /// Asks the planner for what is due, if it is free, and hands in what it has answered.
  void plan();
  /// The answer of the planner, once it is there and its delay is over.
  [[nodiscard]] std::optional<PlanningThread::Reply> answer();
  void post(Request request);

  const RobotModel* robot_;
  const World* world_;
  Posture start_;
  std::string model_text_;
  SimulatedRobot* simulated_ = nullptr;
  std::unique_ptr<TransparentRobot> body_;
  Navigator navigator_;
  Modes modes_;
  Strategy planning_;
  std::optional<PlanningThread> thread_;
  AnswerFaults faults_;
  Dice dice_{0};
  long due_at_ = 0;                             ///< tick from which the answer to the newest request may come
  bool lost_ = false;                           ///< the answer to the newest request is lost
  std::optional<PlanningThread::Reply> ready_;  ///< what was planned on the spot
  double t_ = 0.0;
  long ticks_ = 0;
};

}  // namespace baton
