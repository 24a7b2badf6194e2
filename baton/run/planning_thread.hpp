/// Plans on a separate thread, so that the control loop never waits. Answers may come too late and be dropped: for
/// real-time runs. In a process with real-time priority (`chrt -f 10`) ticks interrupt it. A separate library,
/// `baton::planning_thread`.
#pragma once

#include <atomic>
#include <exception>
#include <optional>
#include <thread>

#include "baton/run/planning.hpp"

namespace baton {

class PlanningThread : public Planning {
 public:
  /// `robot` and `world` must outlive this object.
  PlanningThread(const RobotModel& robot, const World& world, Modes modes);
  ~PlanningThread() override;
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;

  [[nodiscard]] bool idle() const override { return state_.load(std::memory_order_acquire) == State::idle; }

  void post(Request request) override;                          ///< returns at once
  [[nodiscard]] std::optional<Reply> poll(long tick) override;  ///< returns at once

  /// Waits for a planning step under way.
  void reset() override;

 private:
  enum class State { idle, posted, answered, ending };

  void run();

  Strategy strategy_;
  std::atomic<State> state_{State::idle};  ///< says which thread owns `reply_`
  Reply reply_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace baton
