/// A run of the navigator, for tests.
#pragma once

#include <functional>

#include "baton/ik/stand.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/robot/ideal_robot.hpp"

namespace baton::test {

/// A run on the ideal robot, one tick after the other; answers of the planner can be withheld.
class Trip {
 public:
  explicit Trip(const RobotModel& robot, Modes modes = {}, const std::string& world = "flat",
                StateSource source = StateSource::sensors)
      : robot_(&robot),
        world_(World::load(world)),
        home_(stand(robot, world_.site("start"), robot.profile().stance.com_height)),
        navigator_(robot, world_, home_, modes.gait, source),
        strategy_(robot, world_, modes),
        body_(robot, home_, robot.profile().tick.period) {}

  const JointTarget& step(const Command& command, bool answer = true) {
    const Measurement measurement = body_.read();
    if (on_tick) on_tick(true);
    const JointTarget& target = navigator_.tick(measurement, command);
    if (on_tick) on_tick(false);
    body_.write(target);
    navigator_.poll();
    if (auto request = navigator_.request()) {
      ++requests_;
      if (on_request) on_request(*request);
      if (answer) navigator_.answer(strategy_.plan(*request));
    }
    return target;
  }

  /// Called before and after each tick of the navigator.
  std::function<void(bool begins)> on_tick;

  /// Called with each request, before it is answered.
  std::function<void(const Request&)> on_request;

  Navigator& navigator() { return navigator_; }
  [[nodiscard]] const Navigator& navigator() const { return navigator_; }
  IdealRobot& body() { return body_; }
  Strategy& strategy() { return strategy_; }
  /// Where it really is.
  [[nodiscard]] Posture posture() const { return posture_of(*robot_, body_.truth()->q); }
  const World& world() const { return world_; }
  const Posture& home() const { return home_; }
  int requests() const { return requests_; }

 private:
  const RobotModel* robot_;
  World world_;
  Posture home_;
  Navigator navigator_;
  Strategy strategy_;
  IdealRobot body_;
  int requests_ = 0;
};

}  // namespace baton::test
