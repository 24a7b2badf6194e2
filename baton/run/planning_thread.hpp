/// Planning on a thread of its own, so that the loop never waits. Answers come when they are ready, and may be too late
/// to be taken over: for runs by the clock on the wall. A library of its own, `baton::planning_thread`.
#pragma once

#include <atomic>
#include <exception>
#include <optional>
#include <thread>

#include "baton/run/planning.hpp"

namespace baton {

class PlanningThread : public Planning {
 public:
  /// Robot and world must outlive the object.
  PlanningThread(const RobotModel& robot, const World& world, Modes modes);
  ~PlanningThread() override;
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;

  [[nodiscard]] bool idle() const override { return state_.load(std::memory_order_acquire) == State::idle; }

  /// Returns at once.
  void post(Request request) override;

  /// Returns at once.
  [[nodiscard]] std::optional<Reply> poll(long tick) override;

  /// Waits for an answer that is being worked out.
  void reset() override;

 private:
  enum class State { idle, posted, answered, ending };

  void run();

  Strategy strategy_;
  std::atomic<State> state_{State::idle};  ///< says whose turn it is with the reply
  Reply reply_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace baton
