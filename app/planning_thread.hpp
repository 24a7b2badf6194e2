/// Planning on a thread of its own, so that the loop never waits: one problem at a time, one answer.
#pragma once

#include <atomic>
#include <exception>
#include <optional>
#include <thread>

#include "baton/navigate/navigator.hpp"

namespace baton::app {

class PlanningThread {
 public:
  struct Answer {
    Problem problem;
    PlanningResult result;
    double plan_us = 0.0;  ///< CPU time of it [µs]
  };

  /// Robot and world must outlive the object.
  PlanningThread(const RobotModel& robot, const World& world, Modes modes);
  ~PlanningThread();
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;

  /// Whether it waits for a problem.
  [[nodiscard]] bool idle() const { return state_.load(std::memory_order_acquire) == State::idle; }

  /// Hands in a problem; only while it is idle. Returns at once.
  void post(Problem problem);

  /// The answer, once it is there; it is idle from then on. Returns at once.
  /// @throws what planning threw
  [[nodiscard]] std::optional<Answer> poll();

 private:
  enum class State { idle, posted, answered, ending };

  void run();

  Planning planning_;
  std::atomic<State> state_{State::idle};  ///< says whose turn it is with the answer
  Answer answer_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace baton::app
