/// A session with a robot that exists only in the computer.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "baton/robot/simulated_robot.hpp"
#include "baton/run/session.hpp"

namespace baton {

class Simulation {
 public:
  /// sim: physics; ideal: joints do what they are told.
  enum class On { sim, ideal };

  struct Parameters {
    std::optional<Posture> start{};        ///< in the world; none: it stands at the world's site `start`
    SimulatedRobot::Parameters physics{};  ///< of a robot on `sim`
    Session::Parameters session{};
  };

  /// Model and world must outlive the object.
  /// @throws InputError robot and world do not go together
  Simulation(const RobotModel& model, const World& world, On on) : Simulation(model, world, on, Parameters{}) {}
  Simulation(const RobotModel& model, const World& world, On on, const Parameters& parameters);

  [[nodiscard]] Session& session() { return *session_; }
  [[nodiscard]] const Session& session() const { return *session_; }
  /// What the robot's simulator knows.
  [[nodiscard]] const Truth& truth() const { return *robot_->truth(); }
  /// Robot and world in one model, as MJCF text: what is stepped on `sim`.
  [[nodiscard]] const std::string& model_text() const { return model_text_; }
  /// The robot in physics; null on `ideal`.
  [[nodiscard]] SimulatedRobot* simulated() { return simulated_; }

 private:
  std::string model_text_;
  SimulatedRobot* simulated_ = nullptr;
  std::unique_ptr<Robot> robot_;
  std::optional<Session> session_;
};

}  // namespace baton
