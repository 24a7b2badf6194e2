/// CPU time, for statistics only: no result depends on it.
#pragma once

#include <ctime>

namespace baton {

/// CPU time of this thread so far [µs].
[[nodiscard]] inline double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace baton
