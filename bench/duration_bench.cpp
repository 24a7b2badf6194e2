// Durations against the lower bound of the point mass, and why shorter ones fail.
#include <fmt/format.h>

#include <map>

#include "baton/plan/planner.hpp"
#include "baton/plan/shortest.hpp"
#include "bench/bench.hpp"
#include "bench/goals.hpp"
#include "bench/lower_bound.hpp"

namespace baton::bench {
namespace {

constexpr int kGoals = 1000;
constexpr std::size_t kWhole = 150;  ///< tasks planned with the whole body

std::string name_of(const std::optional<Refusal>& refusal) {
  if (!refusal) return "nothing";
  return std::string(to_string(refusal->reason)) + (refusal->where.empty() ? "" : " " + refusal->where);
}

}  // namespace

Rows bench_duration(const Options& /*unused*/) {
  const RobotModel robot = RobotModel::load("mighty");
  const World world = World::load("flat");
  const Profile& profile = robot.profile();
  const double period = profile.tick.period;
  const int longest = static_cast<int>(std::lround(profile.duration.max / period));
  const Limits limits = Limits::normal(profile);
  const int least_swing = static_cast<int>(std::ceil(limits.swing_time / period - 1e-9));

  Row search{"plan: shortest duration of the point mass", {}, ""};
  Row bound{"duration: least of any point mass", {}, "", "s"};
  Row shortest_ratio{"duration: point mass, search / least", {}, "", "1"};
  Row paper_ratio{"duration: point mass, paper's rule / least", {}, "", "1"};
  BoundedCom com;
  std::map<std::string, int> kinds;
  struct Feasible {
    Task task;
    double least;
  };
  std::vector<Feasible> feasible;
  int limited = 0;
  int none_by_search = 0;
  int none_by_paper = 0;
  for (const Task& task : level_tasks(robot, world, kGoals + kGoals / 10, 1)) {
    if (feasible.size() == kGoals) break;
    const Segment segment(robot, task.from, task.goal, limits);
    const ComProblem& problem = segment.com();
    std::optional<Shortest> found;
    time(search, [&] { found = shortest_timing(com, problem, segment.swing_phase(), least_swing, longest, period); });
    const std::optional<int> least = least_ticks(problem, segment.swing_phase(), least_swing, longest, period,
                                                 found ? found->timing.ticks() : longest / 8);
    if (!least) {
      search.values.pop_back();
      continue;
    }
    const ComPlan paper =
        correct_duration(problem, profile.duration.first, profile.duration.step, profile.duration.max, period);
    const auto phases = static_cast<int>(problem.phases.size());
    limited += *least > (segment.swing_phase() ? least_swing + phases - 1 : 1) ? 1 : 0;
    none_by_search += found ? 0 : 1;
    none_by_paper += paper.feasible ? 0 : 1;
    bound.values.push_back(period * *least);
    if (found) shortest_ratio.values.push_back(static_cast<double>(found->timing.ticks()) / *least);
    if (paper.feasible) paper_ratio.values.push_back(static_cast<double>(paper.timing.ticks()) / *least);
    ++kinds[std::string(to_string(task.goal.kind))];
    feasible.push_back({task, period * *least});
  }
  bound.remark = fmt::format("linear program; {} goals ({}), {} of them limited by the ZMP", feasible.size(),
                             counted(kinds), limited);
  search.remark = "all durations and divisions that are looked at";
  shortest_ratio.remark = fmt::format("none found: {}", none_by_search);
  paper_ratio.remark = fmt::format("none up to {} s: {}", profile.duration.max, none_by_paper);

  Rows rows{search, bound, shortest_ratio, paper_ratio};
  for (const DurationRule rule : {DurationRule::search, DurationRule::paper}) {
    const char* name = rule == DurationRule::search ? "search" : "paper's rule";
    Row row{fmt::format("duration: whole body, {} / least", name), {}, "", "1"};
    Planner planner(robot, world, rule);
    std::map<std::string, int> against;
    std::map<std::string, int> refused;
    for (std::size_t i = 0; i < std::min(kWhole, feasible.size()); ++i) {
      const PlanResult planned =
          planner.plan(feasible[i].task.from, feasible[i].task.goal, world.site("start"), limits);
      if (const auto* found = std::get_if<PlannedMotion>(&planned)) {
        row.values.push_back(found->motion->duration() / feasible[i].least);
        ++against[name_of(found->not_shorter)];
      } else {
        ++refused[std::string(to_string(std::get<Refusal>(planned).reason))];
      }
    }
    row.remark = fmt::format("against shorter: {}; refused: {}", counted(against), counted(refused));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace baton::bench
