/// Verified motions to test with: what a robot makes of a random stick on flat ground.
#pragma once

#include "baton/guide/guide.hpp"
#include "baton/ik/stand.hpp"
#include "baton/plan/planner.hpp"
#include "tests/support/robots.hpp"

namespace baton::test {

/// A stick's command at random, each part guided in turn.
inline Command in_turn(std::size_t k, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Command command;
  command.guide = kParts[k % kParts.size()];
  for (double& axis : command.axes)
    axis = uniform(random);
  if (k % 3 == 0) command.lift = {1.0, 1.0};
  return command;
}

/// What the rules know at the nominal standing posture.
inline GuideContext at_home(const RobotModel& robot) {
  GuideContext context;
  context.from = stand(robot, Pose{}, robot.profile().stance.com_height);
  context.foothold = context.from.sole;
  return context;
}

/// The same where a motion has ended.
inline void go_on(GuideContext& context, const Motion& motion) {
  context.from = motion.end;
  for (const Side side : kSides) {
    if (motion.goal.contact[side]) context.foothold[side] = motion.goal.sole[side];
  }
}

/// One after the other from the nominal standing posture, each part guided in turn; made once a process.
inline const std::vector<VerifiedMotion>& sample_motions(const std::string& name) {
  static std::map<std::string, std::vector<VerifiedMotion>> known;
  std::vector<VerifiedMotion>& made = known[name];
  if (!made.empty()) return made;
  const RobotModel& robot = test::robot(name);
  const World world = World::load("flat");
  const Guide guide(robot, world);
  Planner planner(robot, world);
  GuideContext context = at_home(robot);
  std::mt19937_64 random(3);
  for (std::size_t k = 0; k < 30; ++k) {
    const GuideResult guided = guide.goals(context, in_turn(k, random));
    const auto* goals = std::get_if<std::vector<Goal>>(&guided);
    if (goals == nullptr) continue;
    PlanResult planned = planner.plan(context.from, goals->front(), context.anchor, Limits::normal(robot.profile()));
    const auto* found = std::get_if<PlannedMotion>(&planned);
    if (found == nullptr) continue;
    go_on(context, *found->motion);
    made.push_back(found->motion);
  }
  return made;
}

}  // namespace baton::test
