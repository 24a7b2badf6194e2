/// Worker threads that run episodes.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "baton/proving/episode.hpp"

namespace baton {

/// Runs episodes from `first` on in several threads and returns the results in order.
class EpisodePool {
 public:
  EpisodePool(const Episodes& episodes, long first, int jobs)
      : episodes_(&episodes), ahead_(4 * static_cast<std::size_t>(jobs)), next_(first), wanted_(first) {
    for (int i = 0; i < jobs; ++i)
      threads_.emplace_back([this] { work(); });
  }
  ~EpisodePool() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    space_.notify_all();
    for (std::thread& thread : threads_)
      thread.join();
  }
  EpisodePool(const EpisodePool&) = delete;
  EpisodePool& operator=(const EpisodePool&) = delete;

  /// The next episode's result, if ready in time.
  /// @throws any exception that stopped a thread
  [[nodiscard]] std::optional<EpisodeResult> wait(std::chrono::milliseconds time) {
    std::unique_lock<std::mutex> lock(mutex_);
    done_.wait_for(lock, time, [this] { return error_ || results_.contains(wanted_); });
    if (error_) std::rethrow_exception(error_);
    const auto found = results_.find(wanted_);
    if (found == results_.end()) return std::nullopt;
    EpisodeResult result = std::move(found->second);
    results_.erase(found);
    ++wanted_;
    space_.notify_all();
    return result;
  }

 private:
  void work() {
    try {
      for (;;) {
        std::unique_lock<std::mutex> lock(mutex_);
        // Not too far ahead of a slow episode.
        space_.wait(lock, [this] { return stop_ || results_.size() < ahead_; });
        if (stop_) return;
        const long index = next_++;
        lock.unlock();
        EpisodeResult result = episodes_->run(index, stop_);
        lock.lock();
        if (stop_) return;
        results_.emplace(index, std::move(result));
        done_.notify_all();
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      error_ = std::current_exception();
      done_.notify_all();
    }
  }

  const Episodes* episodes_;
  std::size_t ahead_;  ///< most results waiting for an earlier one
  std::mutex mutex_;
  std::condition_variable done_;
  std::condition_variable space_;
  std::atomic<bool> stop_{false};
  long next_;
  long wanted_;
  std::map<long, EpisodeResult> results_;
  std::exception_ptr error_;
  std::vector<std::thread> threads_;
};

}  // namespace baton
