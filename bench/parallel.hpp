/// Runs a function for many seeds on all processors.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

namespace baton::bench {

/// Results of `run(seed)` for seeds 1 … `count` in order; none is started after `patience` [s]. `run` must be
/// thread-safe.
template <typename Run>
auto for_seeds(int count, double patience, const Run& run) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(patience);
  std::vector<decltype(run(std::uint64_t{}))> all(static_cast<std::size_t>(count));
  std::atomic<int> next{0};
  const auto work = [&] {
    while (Clock::now() < end) {
      const int k = next++;
      if (k >= count) return;
      all[static_cast<std::size_t>(k)] = run(static_cast<std::uint64_t>(k) + 1);
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i)
    threads.emplace_back(work);
  for (std::thread& thread : threads)
    thread.join();
  all.resize(static_cast<std::size_t>(std::min(count, next.load())));
  return all;
}

}  // namespace baton::bench
