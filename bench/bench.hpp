/// A small harness: thread CPU time of single calls, as median and 99th percentile, beside a yardstick of the
/// same run.
#pragma once

#include <ctime>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace baton::bench {

inline double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

struct Row {
  std::string name;
  std::vector<double> us;  ///< of each call
  std::string remark;

  [[nodiscard]] double quantile(double share) const {
    std::vector<double> sorted = us;
    std::sort(sorted.begin(), sorted.end());
    if (sorted.empty()) return 0.0;
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
  }
};

/// Times one call; what it computes must be used by the caller.
inline void time(Row& row, const std::function<void()>& call) {
  const double before = cpu_us();
  call();
  row.us.push_back(cpu_us() - before);
}

std::vector<Row> yardstick();
std::vector<Row> bench_plan();
std::vector<Row> bench_ik();
std::vector<Row> bench_run();

}  // namespace baton::bench
