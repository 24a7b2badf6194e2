#include "baton/run/simulation.hpp"

#include "baton/ik/stand.hpp"
#include "baton/robot/calibrated_robot.hpp"
#include "baton/robot/ideal_robot.hpp"

namespace baton {

Simulation::Simulation(const RobotModel& model, const World& world, On on, const Parameters& parameters) {
  const Posture start =
      parameters.start ? *parameters.start : stand(model, world.site("start"), model.profile().stance.com_height);
  const double period = model.profile().tick.period;
  if (on == On::sim) {
    auto simulated = std::make_unique<SimulatedRobot>(model, world, start, period, parameters.physics);
    simulated_ = simulated.get();
    model_text_ = simulated->model_text();
    robot_ = std::move(simulated);
  } else {
    model_text_ = world.compose(model, parameters.physics.timestep);
    robot_ = std::make_unique<IdealRobot>(model, start, period);
  }
  if (parameters.calibration) robot_ = std::make_unique<CalibratedRobot>(std::move(robot_), *parameters.calibration);
  session_.emplace(model, world, *robot_, start, parameters.session);
}

}  // namespace baton
