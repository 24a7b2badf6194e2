#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/session.hpp"
#include "baton/input/script.hpp"
#include "baton/record/plan_json.hpp"

namespace baton::app {

int plan(const PlanOptions& o) {
  const RobotModel robot = RobotModel::load(o.robot);
  const World world = World::load(o.world);
  Script script = Script::load(o.script);
  Session session(robot, world, Session::On::ideal);
  nlohmann::json segments = nlohmann::json::array();
  session.on_plan = [&](const PlanRecord& record) {
    const double t = static_cast<double>(record.problem.take_over) * robot.profile().tick.period;
    nlohmann::json entry = {{"t", t}, {"guide", to_string(record.problem.command.guide)}};
    if (const auto* motion = std::get_if<Motion>(&record.result.outcome)) {
      entry.update(to_json(*motion, record.result.anchor));
    } else if (const auto* refusal = std::get_if<Refusal>(&record.result.outcome)) {
      entry["refused"] = to_json(*refusal);
    } else {
      return;
    }
    segments.push_back(std::move(entry));
  };
  const double end = script.duration() + o.seconds;
  while ((session.t() < end && !interrupted) || !session.resting()) {
    Command command = script.read(session.t());
    if (session.t() >= end || interrupted) command.axes.setZero();
    session.step(command);
  }
  const nlohmann::json result = {{"robot", robot.profile().name}, {"world", world.name()}, {"segments", segments}};
  fmt::print("{}\n", result.dump(2));
  return kDone;
}

}  // namespace baton::app
