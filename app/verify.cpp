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
  nlohmann::json result = {{"robot", robot.profile().name}, {"world", world.name()}, {"T", motion.duration()}};
  Verifier verifier(robot, world);
  const auto verdict = verifier.verify(std::move(motion), place.anchor, Limits::normal(robot.profile()));
  const auto* verified = std::get_if<VerifiedMotion>(&verdict);
  result["verified"] = verified != nullptr;
  if (verified != nullptr) {
    result["margins"] = to_json(verified->certificate());
  } else {
    result["refused"] = to_json(std::get<Refusal>(verdict));
  }
  fmt::print("{}\n", result.dump(2));
  return verified != nullptr ? kDone : kFailed;
}

}  // namespace baton::app
