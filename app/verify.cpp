#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/inputs.hpp"
#include "baton/record/motion_file.hpp"
#include "baton/record/plan_json.hpp"
#include "baton/verify/verifier.hpp"

namespace baton::app {

int verify(const VerifyOptions& o) {
  const MotionPlace place = read_motion_place(o.motion);
  const std::string named = fmt::format("motion {}", o.motion.string());
  const RobotModel robot =
      o.robot ? RobotModel::load(*o.robot) : named_in(named, [&] { return RobotModel::load(place.robot); });
  const World world = o.world ? World::load(*o.world) : named_in(named, [&] { return World::load(place.world); });
  Motion motion = read_motion(o.motion, robot);
  Verifier verifier(robot, world);
  const auto verdict = verifier.verify(motion, place.anchor, Limits::normal(robot.profile()));
  nlohmann::json result = {{"robot", robot.profile().name}, {"world", world.name()}, {"T", motion.duration()}};
  const auto* certificate = std::get_if<Certificate>(&verdict);
  result["verified"] = certificate != nullptr;
  if (certificate != nullptr) {
    result["margins"] = to_json(*certificate);
  } else {
    result["refused"] = to_json(std::get<Refusal>(verdict));
  }
  fmt::print("{}\n", result.dump(2));
  return certificate != nullptr ? kDone : kFailed;
}

}  // namespace baton::app
