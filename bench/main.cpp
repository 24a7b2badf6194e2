#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>

#include "baton/ik/stand.hpp"
#include "bench/bench.hpp"

namespace baton::bench {

Rows yardstick(const Options& /*unused*/) {
  const RobotModel robot = RobotModel::load("mighty");
  const Posture home = stand(robot, Pose{}, robot.profile().stance.com_height);
  const DataPtr data(mj_makeData(&robot.mj()));
  mju_copy(data->qpos, home.q.data(), robot.nq());
  Kinematics kinematics(robot);
  Row yard{"yardstick: kinematics of mighty", {}, "MuJoCo's mj_kinematics and mj_comPos, mean of 20 calls"};
  Row row{"the same of our own", {}, "links, axes, what hangs on each link; mean of 20 calls"};
  for (int k = 0; k < 5000; ++k) {
    time(yard, [&] {
      for (int i = 0; i < 20; ++i) {
        mj_kinematics(&robot.mj(), data.get());
        mj_comPos(&robot.mj(), data.get());
      }
    });
    time(row, [&] {
      for (int i = 0; i < 20; ++i) {
        kinematics.set(home.q);
        (void)kinematics.com();
      }
    });
  }
  for (Row* of : {&yard, &row}) {
    for (double& us : of->values)
      us /= 20.0;
  }
  return {yard, row};
}

}  // namespace baton::bench

int main(int argc, char** argv) {
  using namespace baton::bench;
  const std::vector<std::pair<std::string, Rows (*)(const Options&)>> groups{
      {"plan", bench_plan},       {"duration", bench_duration}, {"segment", bench_segment},
      {"ik", bench_ik},           {"run", bench_run},           {"baseline", bench_baseline},
      {"latency", bench_latency}, {"robots", bench_robots},     {"link", bench_link}};
  CLI::App app("Thread CPU times, durations, a baseline, and latencies, as one table.");
  Options options;
  std::vector<std::string> chosen;
  std::string names;
  for (const auto& [name, bench] : groups)
    names += " " + name;
  app.add_option("groups", chosen, "which of" + names + " (all)");
  app.add_option("--scripts", options.scripts,
                 "for `baseline`: this many for both sides (1000, and what a minute takes)");
  app.add_option("--robot", options.robot,
                 "for `ik`, `latency` and `link`: a name in robots/ or a profile's file (mighty)");
  app.add_option("--trials", options.trials, "for `latency` and `link`: changes of the command (1000)")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--ik-targets", options.ik_targets, "for `ik`: write targets and solutions to this .json file");
  CLI11_PARSE(app, argc, argv);

  fmt::print("{:<44} {:>5} {:>10} {:>10} {:>10} {:>7} {:>8}\n", "", "unit", "median", "p99", "worst", "count",
             "/ yard");
  double yard = 0.0;
  const auto print = [&](const Rows& rows) {
    for (const Row& row : rows) {
      const double median = row.quantile(0.5);
      if (yard == 0.0) yard = median;
      const std::string yards = row.unit == "us" ? fmt::format("{:.1f}", median / yard) : "";
      fmt::print("{:<44} {:>5} {:>10.2f} {:>10.2f} {:>10.2f} {:>7} {:>8}  {}\n", row.name, row.unit, median,
                 row.quantile(0.99), row.quantile(1.0), row.values.size(), yards, row.remark);
    }
    std::fflush(stdout);
  };
  print(yardstick(options));
  for (const auto& [name, bench] : groups) {
    if (chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end()) print(bench(options));
  }
  return 0;
}
