/// Planning on a thread of its own, so that the loop never waits: one request at a time, one answer.
#pragma once

#include <atomic>
#include <exception>
#include <optional>
#include <thread>

#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"

namespace baton {

class PlanningThread {
 public:
  struct Reply {
    Request request;
    Answer result;
    double plan_us = 0.0;  ///< CPU time of it [µs]
  };

  /// Robot and world must outlive the object.
  PlanningThread(const RobotModel& robot, const World& world, Modes modes);
  ~PlanningThread();
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;

  /// Whether it waits for a request.
  [[nodiscard]] bool idle() const { return state_.load(std::memory_order_acquire) == State::idle; }

  /// Hands in a request; only while it is idle. Returns at once.
  void post(Request request);

  /// The answer, once it is there; it is idle from then on. Returns at once.
  /// @throws what planning threw
  [[nodiscard]] std::optional<Reply> poll();

 private:
  enum class State { idle, posted, answered, ending };

  void run();

  Strategy planning_;
  std::atomic<State> state_{State::idle};  ///< says whose turn it is with the answer
  Reply reply_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace baton
