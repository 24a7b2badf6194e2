/// Interface to planning: synchronous, on a thread or on another computer. One request at a time.
#pragma once

#include <optional>

#include "baton/plan/strategy.hpp"

namespace baton {

class Planning {
 public:
  struct Reply {
    Request request;
    Answer answer;
    double plan_us = 0.0;  ///< CPU time of planning [µs]
  };

  virtual ~Planning() = default;

  /// Whether a request can be posted.
  [[nodiscard]] virtual bool idle() const = 0;

  /// Submits a request. Requires `idle()`.
  virtual void post(Request request) = 0;

  /// Returns the answer once it is ready, and is idle from then on. Called every tick, before and after a request is
  /// posted.
  /// @param tick number of the tick since the start of the run
  /// @throws any exception of the planner
  [[nodiscard]] virtual std::optional<Reply> poll(long tick) = 0;

  /// Drops the pending request, if any, and returns to the state after construction.
  virtual void reset() = 0;
};

/// Plans synchronously: the answer is ready when `post` returns.
class DirectPlanning : public Planning {
 public:
  /// `robot` and `world` must outlive this object.
  DirectPlanning(const RobotModel& robot, const World& world, Modes modes) : strategy_(robot, world, modes) {}

  [[nodiscard]] bool idle() const override { return !ready_; }
  void post(Request request) override;
  [[nodiscard]] std::optional<Reply> poll(long tick) override;
  void reset() override { ready_.reset(); }

 private:
  Strategy strategy_;
  std::optional<Reply> ready_;
};

}  // namespace baton
