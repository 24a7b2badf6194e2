#include "app/reproduce.hpp"

#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "baton/model/error.hpp"

namespace baton::app {

int reproduce(const ReproduceOptions& options) {
  const bool physics = options.what != "fig8";
  if (!physics && options.plant) throw InputError("--plant goes with room and walks: fig8 is planned, not simulated");
  if (!physics && options.seed) throw InputError("--seed goes with room and walks: fig8 has nothing to draw");
  make_folder(options.out, "--out");
  if (!physics) return reproduce_fig8(options.out);
  const RobotModel robot = RobotModel::load("mighty");
  PhysicsOptions plant;
  plant.plant = options.plant;
  const long seed = options.seed.value_or(0);
  const SimulatedRobot::Parameters parameters = parameters_of(plant, robot, "sim", seed);
  return options.what == "room" ? reproduce_room(robot, parameters, seed, options.out)
                                : reproduce_walks(robot, parameters, seed, options.out);
}

}  // namespace baton::app
