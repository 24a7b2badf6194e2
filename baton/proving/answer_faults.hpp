/// Fault injection: planner answers that are delayed or lost.
#pragma once

#include "baton/proving/dice.hpp"
#include "baton/run/planning.hpp"

namespace baton {

struct AnswerFaults {
  double delay = 0.0;  ///< largest delay of an answer [s]
  double loss = 0.0;   ///< fraction of answers lost

  [[nodiscard]] bool any() const { return delay > 0.0 || loss > 0.0; }
};

/// Wraps a planner and delays or drops its answers at random.
class FaultyPlanning : public Planning {
 public:
  /// @param planning must outlive this object
  /// @param period of a tick [s]
  /// @param seed seed of delays and losses
  FaultyPlanning(Planning& planning, const AnswerFaults& faults, double period, std::uint64_t seed);

  [[nodiscard]] bool idle() const override { return planning_->idle(); }
  void post(Request request) override;
  [[nodiscard]] std::optional<Reply> poll(long tick) override;
  void reset() override;

 private:
  Planning* planning_;
  int latest_;  ///< largest delay of an answer [ticks]
  double loss_;
  std::uint64_t seed_;
  Dice dice_;
  long now_ = 0;       ///< tick of the last poll
  long due_ = 0;       ///< tick from which the newest answer is delivered
  bool lost_ = false;  ///< the newest answer is lost
};

}  // namespace baton
