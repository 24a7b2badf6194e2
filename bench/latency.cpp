#include "bench/latency.hpp"

#include <cmath>
#include <numbers>

#include "baton/ik/stand.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "bench/bench.hpp"
#include "bench/draw.hpp"
#include "bench/scripts.hpp"

namespace baton::bench {
namespace {

constexpr double kDifferent = 1e-9;  ///< threshold on joint targets [rad]
constexpr double kRest = 1.0;        ///< wait for a motion, beyond the longest one under way [s]

/// A run, tick by tick.
struct Run {
  Run(const RobotModel& robot, const World& world, const Posture& start)
      : navigator(robot, world, start), body(robot, start, robot.profile().tick.period) {}

  void tick(const Command& command) {
    const JointTarget& target = navigator.tick(body.read(), command);
    navigator.poll();
    body.write(target);
    q = target.q;
  }

  Navigator navigator;
  IdealRobot body;
  VecX q;  ///< joint target of this tick
};

bool differ(const Run& a, const Run& b) {
  return (a.q - b.q).cwiseAbs().maxCoeff() > kDifferent;
}

/// Full deflection of one axis, or in a horizontal direction; a foot may be lifted.
Command deflected(Draw& draw, const RobotModel& robot, Part part) {
  Command command;
  command.guide = part;
  if (draw.chance(0.5)) {
    while (requested_move(robot, command).isZero(0.0)) {  // until it is an axis that the part can use
      command.axes.setZero();
      command.axes[draw.below(6)] = draw.chance(0.5) ? 1.0 : -1.0;
    }
  } else {
    const double angle = draw.real(-std::numbers::pi, std::numbers::pi);
    command.axes.head<2>() << std::cos(angle), std::sin(angle);
  }
  if (is_foot(part) && draw.chance(0.3)) command.lift[side_of(part)] = draw.real(0.2, 1.0);
  return command;
}

Part any_part(Draw& draw) {
  return kParts[static_cast<std::size_t>(draw.below(5))];
}

/// The stick before the change: centred, or released; walking; a foot; a hand; one part, then another.
std::vector<Stretch> prelude(Draw& draw, const RobotModel& robot) {
  std::vector<Stretch> script;
  const auto add = [&](double least, double most, const Command& command) {
    script.push_back({(script.empty() ? 0.0 : script.back().until) + draw.real(least, most), command});
  };
  const auto let_go = [&](double most) { add(0.05, most, Command{.guide = script.back().command.guide}); };
  switch (draw.below(5)) {
    case 0:
      add(0.05, 2.0, draw.chance(0.5) ? Command{} : deflected(draw, robot, any_part(draw)));
      let_go(3.0);
      break;
    case 1:
      add(0.05, 4.0, deflected(draw, robot, Part::trunk));
      break;
    case 2:
      add(0.05, 1.5, deflected(draw, robot, foot(draw.chance(0.5) ? Side::left : Side::right)));
      break;
    case 3:
      add(0.3, 2.0, deflected(draw, robot, hand(draw.chance(0.5) ? Side::left : Side::right)));
      if (draw.chance(0.5)) let_go(1.0);
      break;
    default:
      add(0.3, 2.0, deflected(draw, robot, any_part(draw)));
      add(0.05, 1.0, deflected(draw, robot, any_part(draw)));
  }
  return script;
}

/// Another part, or a direction at least 60° different.
bool really_different(const Command& a, const Command& b) {
  return a.guide != b.guide || a.axes.dot(b.axes) <= 0.5 * a.axes.norm() * b.axes.norm();
}

Situation situation_of(const Navigator& navigator) {
  switch (navigator.phase()) {
    case Phase::hold:
      return Situation::at_rest;
    case Phase::double_support:
      return Situation::double_support;
    default:
      return Situation::foot_in_air;
  }
}

}  // namespace

Change change_of_command(const RobotModel& robot, const World& world, std::uint64_t seed) {
  Draw draw(seed);
  const std::vector<Stretch> script = prelude(draw, robot);
  const Command& old = script.back().command;
  Command fresh;
  do {
    fresh = deflected(draw, robot, draw.chance(0.5) ? old.guide : any_part(draw));
  } while (!really_different(old, fresh));

  const Profile& profile = robot.profile();
  const double period = profile.tick.period;
  const Posture start = stand(robot, world.site("start"), profile.stance.com_height);
  Strategy strategy(robot, world);
  Run changed(robot, world, start);
  Run held(robot, world, start);
  Run unanswered(robot, world, start);
  long tick = 0;
  for (const Stretch& stretch : script) {
    for (; static_cast<double>(tick) * period < stretch.until; ++tick) {
      for (Run* run : {&changed, &held, &unanswered})
        run->tick(stretch.command);
      // The runs are identical so far, so one answer serves all.
      const std::optional<Request> request = changed.navigator.request();
      if (!request) continue;
      const Answer result = strategy.plan(*request);
      changed.navigator.answer(result);
      for (Run* run : {&held, &unanswered}) {
        if (run->navigator.request()) run->navigator.answer(result);
      }
    }
  }

  Change change;
  change.situation = situation_of(changed.navigator);
  change.switched = fresh.guide != old.guide;
  const long patience = std::lround((profile.duration.max + kRest) / period);
  for (long k = 0; k < patience; ++k) {
    changed.tick(fresh);
    held.tick(old);
    unanswered.tick(fresh);
    if (differ(changed, held) && differ(changed, unanswered)) {
      change.latency = static_cast<double>(k) * period;
      break;
    }
    if (const std::optional<Request> request = held.navigator.request()) held.navigator.answer(strategy.plan(*request));
    const std::optional<Request> request = changed.navigator.request();
    if (!request) continue;
    const double before = cpu_us();
    Answer result = strategy.plan(*request);
    change.plan_us.push_back(cpu_us() - before);
    const auto* refusal = std::get_if<Refusal>(&result.outcome);
    if (change.plan_us.size() == 1 && !std::holds_alternative<PlannedMotion>(result.outcome))
      change.first_against = refusal != nullptr ? to_string(refusal->reason) : "nothing to do";
    changed.navigator.answer(std::move(result));
  }
  return change;
}

}  // namespace baton::bench
