/// Faults of the planner's answers on their way to the navigator.
#pragma once

#include "baton/proving/dice.hpp"
#include "baton/run/planning.hpp"

namespace baton {

struct AnswerFaults {
  double delay = 0.0;  ///< each comes late, by at most this [s]
  double loss = 0.0;   ///< share of answers that never come

  [[nodiscard]] bool any() const { return delay > 0.0 || loss > 0.0; }
};

/// A planner whose answers come late or not at all, at random.
class FaultyPlanning : public Planning {
 public:
  /// @param planning must outlive the object
  /// @param period of a tick [s]
  /// @param seed of the delays and losses
  FaultyPlanning(Planning& planning, const AnswerFaults& faults, double period, std::uint64_t seed);

  [[nodiscard]] bool idle() const override { return planning_->idle(); }
  void post(Request request) override;
  [[nodiscard]] std::optional<Reply> poll(long tick) override;
  void reset() override;

 private:
  Planning* planning_;
  int latest_;  ///< [ticks] that an answer is late, at most
  double loss_;
  std::uint64_t seed_;
  Dice dice_;
  long now_ = 0;       ///< tick of the last poll
  long due_ = 0;       ///< tick from which the newest answer may come
  bool lost_ = false;  ///< the newest answer is
};

}  // namespace baton
