#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "baton/input/script.hpp"
#include "baton/record/motion_file.hpp"
#include "baton/record/plan_json.hpp"
#include "baton/run/session.hpp"

namespace baton::app {

int plan(const PlanOptions& o) {
  const RobotModel robot = RobotModel::load(o.robot);
  const World world = World::load(o.world);
  Script script = Script::load(o.script, interrupted);
  Simulation simulation(robot, world, Simulation::On::ideal, {.session = {.modes = modes_of(o.modes)}});
  Session& session = simulation.session();
  if (o.out) make_folder(*o.out, "--out");
  nlohmann::json segments = nlohmann::json::array();
  int motions = 0;
  Hooks hooks;
  hooks.plan = [&](const PlanRecord& record) {
    const double t = static_cast<double>(record.request.at) * robot.profile().tick.period;
    nlohmann::json entry = {{"t", t}, {"guide", to_string(record.request.command.guide)}};
    if (const auto* planned = std::get_if<PlannedMotion>(&record.answer.outcome)) {
      entry.update(to_json(*planned, record.answer.context.anchor));
      if (o.out) {
        const auto file = *o.out / fmt::format("segment_{:03}.json", motions++);
        write_whole(file, "--out",
                    motion_file(*planned->motion, {o.robot, o.world, record.answer.context.anchor}).dump() + '\n');
        entry["file"] = file.string();
      }
    } else if (const auto* refusal = std::get_if<Refusal>(&record.answer.outcome)) {
      if (record.request.start.context.stick_held) return;  // the request is repeated at rest
      entry["refused"] = to_json(*refusal);
    } else {
      return;
    }
    segments.push_back(std::move(entry));
  };
  session.add(hooks);
  const double end = script.duration() + o.seconds;
  while ((session.t() < end && !interrupted) || !session.resting()) {
    Command command = script.read(session.t());
    if (session.t() >= end || interrupted) {
      command.axes.setZero();
      command.recall = Recall::none;
    }
    session.step(command);
  }
  const nlohmann::json result = {{"robot", robot.profile().name}, {"world", world.name()}, {"segments", segments}};
  fmt::print("{}\n", result.dump(2));
  if (!interrupted) return kDone;
  spdlog::warn("interrupted: the plan is incomplete");
  return kFailed;
}

}  // namespace baton::app
