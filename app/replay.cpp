#include <fmt/format.h>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/session.hpp"
#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/record/recording.hpp"

namespace baton::app {
namespace {

ModeOptions modes_in(const nlohmann::json& head) {
  return {head.at("duration").get<std::string>(), head.at("gait").get<std::string>(),
          head.at("on_limit").get<std::string>()};
}

}  // namespace

int replay(const ReplayOptions& o) {
  RecordingReader recording(o.recording);
  const nlohmann::json& head = recording.head();
  const RobotModel robot = load_robot(head.value("robot", ""), head.value("drive", ""));
  const World world = World::load(head.value("world", ""));
  ModeOptions options;
  try {
    options = modes_in(head);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("recording {}: {}", o.recording.string(), error.what()));
  }
  const Modes modes = modes_of(options);
  Navigator navigator(robot, world, stand(robot, world.site("start"), robot.profile().stance.com_height), modes.gait,
                      state_named(head.value("state", "")));
  Planning planning(robot, world, modes);
  std::optional<PlanningResult> answer;
  const auto differs = [&](const std::string& what) {
    fmt::print("tick {}: {}\n", navigator.now(), what);
    return kFailed;
  };
  while (const std::optional<RecordedTick> tick = recording.next()) {
    if (tick->measurement.q.size() != robot.nv() - 6) {
      throw InputError(fmt::format("recording {}: {} joints, the robot {} has {}", o.recording.string(),
                                   tick->measurement.q.size(), robot.profile().name, robot.nv() - 6));
    }
    if (tick->fallen) navigator.fall();
    const std::string sum = checksum(navigator.tick(tick->measurement, tick->command));
    navigator.poll();
    if (o.verify && sum != tick->checksum) return differs("other joint targets than were recorded");
    for (const PlanningEvent event : tick->events) {
      if (event == PlanningEvent::offer) {
        if (answer) navigator.offer(*std::move(answer));
        answer.reset();
        continue;
      }
      const std::optional<Problem> problem = navigator.request();
      if (!problem && o.verify) return differs("nothing is asked of the planner, as it was when it was recorded");
      if (problem) answer = planning.plan(*problem);
    }
  }
  fmt::print("{} ticks, {:.1f} s: {} segments, {} answers too late{}\n", navigator.now() + 1,
             static_cast<double>(navigator.now() + 1) * robot.profile().tick.period, navigator.committed(),
             navigator.dropped(), o.verify ? ", the same joint targets bit by bit" : "");
  return kDone;
}

}  // namespace baton::app
