#include "baton/record/segment_count.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace baton {

double SegmentCount::travel(const Vec3& com) const {
  return !executing_ ? travel_ : travel_ + (com - com_start_).head<2>().norm();
}

void SegmentCount::add(const Navigator& navigator, const Vec3& com) {
  caught_ = navigator.caught();
  slips_ = navigator.slips();
  const std::span<const Event> events = navigator.events();
  const bool begins = find_event<Committed>(events) != nullptr;
  if (begins || find_event<Ended>(events) != nullptr) {
    travel_ = travel(com);
    executing_ = begins;
  }
  if (begins) {
    ++committed_;
    com_start_ = com;
    const PlannedMotion& planned = *navigator.planned();
    if (planned.limit) ++shrunk_[std::string(to_string(planned.limit->reason))];
    for (const Margin& margin : planned.motion.certificate().margins) {
      if (margin.quantity == Reason::zmp) zmp_margin_ = std::min(zmp_margin_, margin.value);
    }
  }
  if (!(navigator.command() == command_)) last_refused_.clear();
  command_ = navigator.command();
  if (find_event<Refused>(events) == nullptr) return;
  const Refusal& refusal = *navigator.refusal();
  const std::string key = fmt::format("{} {}", to_string(refusal.reason), to_string(refusal.part));
  if (key != last_refused_) ++refused_[std::string(to_string(refusal.reason))];
  last_refused_ = key;
}

nlohmann::json SegmentCount::json() const {
  return {{"committed", committed_},
          {"caught", caught_},
          {"slips", slips_},
          {"shrunk", nlohmann::json(shrunk_)},
          {"refused", nlohmann::json(refused_)}};
}

}  // namespace baton
