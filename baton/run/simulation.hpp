/// A session with a simulated or ideal robot, or one that is given.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "baton/robot/calibration.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "baton/run/session.hpp"

namespace baton {

class Simulation {
 public:
  /// sim: physics; ideal: joints track their targets exactly.
  enum class On { sim, ideal };

  struct Parameters {
    std::optional<Posture> start{};        ///< in the world frame; default: standing at the world's site `start`
    SimulatedRobot::Parameters physics{};  ///< for `sim`
    Session::Parameters session{};
    std::optional<Calibration> calibration{};  ///< what is known of the sensors' errors
  };

  /// `model` and `world` must outlive this object.
  /// @throws InputError robot and world cannot be combined
  Simulation(const RobotModel& model, const World& world, On on) : Simulation(model, world, on, Parameters{}) {}
  Simulation(const RobotModel& model, const World& world, On on, const Parameters& parameters);
  /// With a robot that stands at `parameters.start`; `parameters.physics` does not matter.
  Simulation(const RobotModel& model, const World& world, std::unique_ptr<Robot> robot, const Parameters& parameters);

  [[nodiscard]] Session& session() { return *session_; }
  [[nodiscard]] const Session& session() const { return *session_; }
  /// Requires that the robot has truth, as simulated and ideal ones have.
  [[nodiscard]] const Truth& truth() const { return *robot_->truth(); }
  /// Robot and world as one MJCF model; on `sim` the one that is simulated.
  [[nodiscard]] std::string model_text(Visuals visuals = Visuals::keep) const;
  /// Null on `ideal`, and for a robot that was given.
  [[nodiscard]] SimulatedRobot* simulated() { return simulated_; }

 private:
  void begin(const Posture& start, const Parameters& parameters);

  const RobotModel* model_;
  const World* world_;
  double timestep_;
  SimulatedRobot* simulated_ = nullptr;
  std::unique_ptr<Robot> robot_;
  std::optional<Session> session_;
};

}  // namespace baton
