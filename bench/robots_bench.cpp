// Each robot of robots/ whose model is there, in physics on the plant `real`: what planning it costs, how fast it
// walks, how well it follows its plan, and whether it falls.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "baton/proving/scenario.hpp"
#include "baton/record/report.hpp"
#include "baton/run/simulation.hpp"
#include "bench/bench.hpp"

namespace baton::bench {
namespace {

constexpr int kRealRuns = 4;             ///< with random sticks
constexpr double kRandomSeconds = 30.0;  ///< of each [s]
constexpr double kHeldSeconds = 20.0;    ///< of a stick that is held forward [s]
constexpr double kBegun = 4.0;           ///< from then on the speed is measured [s]
constexpr std::size_t kVerified = 100;   ///< motions whose verification is timed

std::vector<std::string> robots_with_models() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(share_dir() / "robots")) {
    const std::string name = entry.path().filename().string();
    if (name == "mighty" || std::filesystem::exists(entry.path() / "model")) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

Simulation::Parameters on_real(const RobotModel& robot, std::uint64_t seed) {
  Simulation::Parameters parameters;
  parameters.physics.plant = real_plant(robot, seed);
  return parameters;
}

/// Speed at which the first body gets ahead while the stick is held forward: its displacement over the time.
Row held_stick(const RobotModel& robot, const World& world) {
  Row row{robot.profile().name + ": speed with the stick held forward", {}, "", "m/s"};
  for (std::uint64_t seed = 0; seed < kRealRuns; ++seed) {
    Simulation simulation(robot, world, Simulation::On::sim, on_real(robot, seed));
    Session& session = simulation.session();
    Command forward;
    forward.axes[0] = 1.0;
    Vec2 from = Vec2::Zero();
    while (session.t() < kHeldSeconds && !session.fallen()) {
      if (session.t() < kBegun) from = simulation.truth().q.head<2>();
      session.step(forward);
    }
    if (session.t() > kBegun)
      row.values.push_back((simulation.truth().q.head<2>() - from).norm() / (session.t() - kBegun));
  }
  row.remark = fmt::format("median and best of {} plants", kRealRuns);
  return row;
}

Rows rows_of(const RobotModel& robot, const World& world) {
  const std::string name = robot.profile().name;
  const Limits limits = Limits::normal(robot.profile());
  Rows rows = ik_rows(robot, name + ": ");
  Row segment{
      name + ": plan: a committed segment", {}, "planned again from its goal, realised at every tick, verified"};
  Row plan{name + ": plan: a request answered by a motion", {}, "guide, all its goals, landing, shrinking"};
  Row verify{name + ": verify: a motion", {}, ""};
  Row com{name + ": COM error with random sticks, rms", {}, "", "mm"};
  Planner planner(robot, world, Modes{}.duration);
  Verifier verifier(robot, world);
  double seconds = 0.0;
  int falls = 0;
  long given = 0;
  long moved = 0;
  for (std::uint64_t seed = 0; seed < kRealRuns; ++seed) {
    Simulation simulation(robot, world, Simulation::On::sim, on_real(robot, seed));
    Session& session = simulation.session();
    const std::unique_ptr<Device> stick = stick_of(scenario_named("real"), robot, seed);
    Report report(robot);
    Hooks hooks;
    hooks.plan = [&](const PlanRecord& record) {
      const auto* planned = std::get_if<PlannedMotion>(&record.answer.outcome);
      if (planned == nullptr) return;
      plan.values.push_back(record.plan_us);
      time(segment, [&] {
        static_cast<void>(planner.plan(record.request.start.posture, planned->motion->goal,
                                       record.request.start.context.anchor, limits));
      });
      if (verify.values.size() == kVerified) return;
      Motion motion = *planned->motion;
      time(verify,
           [&] { static_cast<void>(verifier.verify(std::move(motion), record.request.start.context.anchor, limits)); });
    };
    session.add(report);
    session.add(hooks);
    while (session.t() < kRandomSeconds && !session.fallen())
      session.step(stick->read(session.t()));
    seconds += session.t();
    falls += session.fallen() ? 1 : 0;
    const nlohmann::json summary = report.json(world.name(), "sim", static_cast<long>(seed), 0.0);
    given += summary["commands"]["given"].get<long>();
    moved += summary["commands"]["moved"].get<long>();
    com.values.push_back(1e3 * summary["tracking"]["com_rms_m"].get<double>());
  }
  verify.remark = "dynamics, contacts, distances, heat at every tick";
  // Of a Poisson process, by 95 %, without a fall: at most −ln 0.05 = 3.0 in that time.
  com.remark = fmt::format("{} of {} commands moved; {} falls in {:.0f} s{}", moved, given, falls, seconds,
                           falls == 0 ? fmt::format(" (at most {:.0f} an hour)", 3.0 * 3600.0 / seconds) : "");
  for (Row* row : {&segment, &plan, &verify, &com})
    rows.push_back(std::move(*row));
  rows.push_back(held_stick(robot, world));
  return rows;
}

}  // namespace

Rows bench_robots(const Options& /*unused*/) {
  const World world = World::load("flat");
  Rows all;
  for (const std::string& name : robots_with_models()) {
    for (Row& row : rows_of(RobotModel::load(name), world))
      all.push_back(std::move(row));
  }
  return all;
}

}  // namespace baton::bench
