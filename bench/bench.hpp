/// A small benchmark harness: median, 99th percentile and worst value of per-call CPU time and other quantities.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "baton/model/robot_model.hpp"
#include "baton/run/cpu_time.hpp"

namespace baton::bench {

struct Row {
  std::string name;
  std::vector<double> values;  ///< one per call
  std::string remark;
  std::string unit = "us";

  [[nodiscard]] double quantile(double share) const {
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    if (sorted.empty()) return 0.0;
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
  }
};

/// "12 this, 3 that", most frequent first.
inline std::string counted(const std::map<std::string, int>& count) {
  std::vector<std::pair<int, std::string>> sorted;
  sorted.reserve(count.size());
  for (const auto& [name, n] : count)
    sorted.emplace_back(-n, name);
  std::sort(sorted.begin(), sorted.end());
  std::string text;
  for (const auto& [n, name] : sorted)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", -n, name);
  return text;
}

/// Times one call; the caller must use its result.
inline void time(Row& row, const std::function<void()>& call) {
  const double before = cpu_us();
  call();
  row.values.push_back(cpu_us() - before);
}

struct Options {
  int scripts =
      0;  ///< scripts for the baseline comparison; 0: 1,000 for the baseline, as many of ours as fit in a minute
  std::string robot = "mighty";  ///< for inverse kinematics, the latencies and the connection
  int trials = 1000;             ///< for the last two: changes of the command
  std::string ik_targets;        ///< file for the robot, the targets of inverse kinematics and the solutions, if any
};

using Rows = std::vector<Row>;
Rows yardstick(const Options&);
Rows bench_plan(const Options&);
Rows bench_duration(const Options&);
Rows bench_segment(const Options&);
Rows bench_ik(const Options&);
Rows bench_run(const Options&);
Rows bench_baseline(const Options&);
Rows bench_latency(const Options&);
Rows bench_link(const Options&);
Rows link_in_real_time(const Options&);
Rows bench_robots(const Options&);

/// Inverse kinematics of a robot that walks and reaches.
/// @param motions takes the targets, solutions and times of each tick, if given
Rows ik_rows(const RobotModel& robot, const std::string& prefix, nlohmann::json* motions = nullptr);

}  // namespace baton::bench
