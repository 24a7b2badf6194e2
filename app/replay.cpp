#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/inputs.hpp"
#include "app/options.hpp"
#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/record/recording.hpp"
#include "baton/run/session.hpp"

namespace baton::app {
namespace {

/// Whether all bits are equal; a recording does not keep the bits of a NaN.
bool same_bits(const VecX& a, const VecX& b) {
  const auto same = [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y) || (std::isnan(x) && std::isnan(y));
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

/// @throws InputError it is one of another robot
Posture start_of(const RecordingHead& head, const std::string& place, const RobotModel& robot, const World& world) {
  if (head.start.empty()) return stand(robot, world.site("start"), robot.profile().stance.com_height);
  if (head.start.size() != static_cast<std::size_t>(robot.nq()))
    throw InputError(
        fmt::format("{}: start has {} members: must be a list of {} numbers", place, head.start.size(), robot.nq()));
  return posture_of(robot, Eigen::Map<const VecX>(head.start.data(), robot.nq()));
}

}  // namespace

int replay(const ReplayOptions& o) {
  RecordingReader recording(o.recording);
  const RecordingHead& head = recording.head();
  const RobotModel robot = named_in(recording.place(), [&] { return load_robot(head.robot, head.drive); });
  const World world = named_in(recording.place(), [&] { return World::load(head.world); });
  const Modes modes = modes_of({head.duration, head.gait, head.on_limit});
  Navigator navigator(robot, world, start_of(head, recording.place(), robot, world), modes.gait,
                      state_named(head.state));
  Strategy strategy(robot, world, modes);
  std::optional<Answer> answer;
  const auto differs = [&](const std::string& what) {
    fmt::print("tick {}: {}\n", navigator.now(), what);
    return kFailed;
  };
  while (const std::optional<RecordedTick> tick = recording.next(robot.nv() - 6)) {
    if (interrupted) return differs("interrupted");
    const JointTarget& target = navigator.tick(tick->measurement, tick->command);
    if (o.verify && !(same_bits(target.q, tick->target) && checksum(target) == tick->checksum)) {
      return differs("the joint targets differ from the recorded ones");
    }
    const HealthChanges sensors = health_changes(navigator.events());
    if (o.verify && sensors != tick->sensors) return differs("the sensors' health differs from the recorded one");
    for (const auto& [sensor, health] : sensors)
      fmt::print("tick {}: sensor {} is {}\n", navigator.now(), sensor, health);
    navigator.poll();
    for (const PlanningEvent event : tick->events) {
      if (event == PlanningEvent::answer) {
        if (answer) navigator.answer(*std::move(answer));
        answer.reset();
        continue;
      }
      const std::optional<Request> request = navigator.request();
      if (!request && o.verify) return differs("no planning request is due, unlike in the recording");
      if (request) answer = strategy.plan(*request);
    }
  }
  fmt::print("{} ticks, {:.1f} s: {} segments, {} answers too late{}\n", navigator.now() + 1,
             static_cast<double>(navigator.now() + 1) * robot.profile().tick.period, navigator.committed(),
             navigator.dropped(), o.verify ? ", joint targets identical bit for bit" : "");
  return kDone;
}

}  // namespace baton::app
