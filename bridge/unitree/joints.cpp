#include "bridge/unitree/joints.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "baton/model/error.hpp"

namespace baton::unitree {

std::vector<std::size_t> motors_of(const RobotModel& model) {
  std::vector<std::size_t> motors;
  for (const Joint& joint : model.joints()) {
    const auto* const found = std::find(kJoints.begin(), kJoints.end(), joint.name);
    if (found == kJoints.end())
      throw InputError(fmt::format("--robot {}: a G1 has no joint '{}'", model.profile().name, joint.name));
    motors.push_back(static_cast<std::size_t>(found - kJoints.begin()));
  }
  for (std::size_t motor = 0; motor < kJoints.size(); ++motor) {
    if (std::find(motors.begin(), motors.end(), motor) == motors.end())
      throw InputError(
          fmt::format("--robot {}: has no joint '{}', which a G1 has", model.profile().name, kJoints[motor]));
  }
  return motors;
}

}  // namespace baton::unitree
