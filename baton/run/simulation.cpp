#include "baton/run/simulation.hpp"

#include "baton/ik/stand.hpp"
#include "baton/robot/calibrated_robot.hpp"
#include "baton/robot/ideal_robot.hpp"

namespace baton {
namespace {

Posture start_of(const RobotModel& model, const World& world, const Simulation::Parameters& parameters) {
  return parameters.start ? *parameters.start : stand(model, world.site("start"), model.profile().stance.com_height);
}

}  // namespace

Simulation::Simulation(const RobotModel& model, const World& world, On on, const Parameters& parameters)
    : model_(&model), world_(&world), timestep_(parameters.physics.timestep) {
  const Posture start = start_of(model, world, parameters);
  const double period = model.profile().tick.period;
  if (on == On::sim) {
    auto simulated = std::make_unique<SimulatedRobot>(model, world, start, period, parameters.physics);
    simulated_ = simulated.get();
    robot_ = std::move(simulated);
  } else {
    robot_ = std::make_unique<IdealRobot>(model, start, period);
  }
  begin(start, parameters);
}

Simulation::Simulation(const RobotModel& model, const World& world, std::unique_ptr<Robot> robot,
                       const Parameters& parameters)
    : model_(&model), world_(&world), timestep_(parameters.physics.timestep), robot_(std::move(robot)) {
  begin(start_of(model, world, parameters), parameters);
}

void Simulation::begin(const Posture& start, const Parameters& parameters) {
  if (parameters.calibration) robot_ = std::make_unique<CalibratedRobot>(std::move(robot_), *parameters.calibration);
  session_.emplace(*model_, *world_, *robot_, start, parameters.session);
}

std::string Simulation::model_text(Visuals visuals) const {
  return simulated_ != nullptr ? simulated_->model_text(visuals) : world_->compose(*model_, timestep_, visuals);
}

}  // namespace baton
