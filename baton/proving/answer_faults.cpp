#include "baton/proving/answer_faults.hpp"

#include <cmath>
#include <utility>

namespace baton {
namespace {

Dice dice_of(std::uint64_t seed) {
  return Dice(mixed_seed(seed, 79));
}

}  // namespace

FaultyPlanning::FaultyPlanning(Planning& planning, const AnswerFaults& faults, double period, std::uint64_t seed)
    : planning_(&planning),
      latest_(static_cast<int>(std::lround(faults.delay / period))),
      loss_(faults.loss),
      seed_(seed),
      dice_(dice_of(seed)) {}

void FaultyPlanning::post(Request request) {
  due_ = now_ + dice_.between(0, latest_);
  lost_ = dice_.share() < loss_;
  planning_->post(std::move(request));
}

std::optional<Planning::Reply> FaultyPlanning::poll(long tick) {
  now_ = tick;
  if (now_ < due_) return std::nullopt;
  std::optional<Reply> reply = planning_->poll(tick);
  return lost_ ? std::nullopt : std::move(reply);
}

void FaultyPlanning::reset() {
  planning_->reset();
  dice_ = dice_of(seed_);
  now_ = due_ = 0;
  lost_ = false;
}

}  // namespace baton
