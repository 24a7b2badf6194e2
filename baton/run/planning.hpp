/// Port for where planning happens: on the spot, on a thread, on another computer. One request at a time, one answer.
#pragma once

#include <optional>

#include "baton/plan/strategy.hpp"

namespace baton {

class Planning {
 public:
  struct Reply {
    Request request;
    Answer result;
    double plan_us = 0.0;  ///< CPU time of it [µs]
  };

  virtual ~Planning() = default;

  /// Whether it waits for a request.
  [[nodiscard]] virtual bool idle() const = 0;

  /// Hands in a request; only while it is idle.
  virtual void post(Request request) = 0;

  /// The answer, once it is there; idle from then on. Called in every tick, before a request is posted and after it.
  /// @param tick since the start of the run
  /// @throws what planning threw
  [[nodiscard]] virtual std::optional<Reply> poll(long tick) = 0;

  /// Drops the request under way, if any: idle from then on, as if newly constructed.
  virtual void reset() = 0;
};

/// Plans on the spot: `post` returns when the answer is there.
class DirectPlanning : public Planning {
 public:
  /// Robot and world must outlive the object.
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
