#include "baton/navigate/history.hpp"

#include <algorithm>
#include <utility>

namespace baton {
namespace {

constexpr std::ptrdiff_t kTrails = 200;  ///< that are kept
constexpr long kTicks = 100000;          ///< of all of them together

}  // namespace

History::History() {
  trails_.reserve(static_cast<std::size_t>(kTrails) + 1);
}

void History::replace_newest(std::shared_ptr<const Trail> trail, Retired& retired) {
  if (empty()) return;
  retired.keep(std::exchange(trails_.back(), std::move(trail)));
}

std::shared_ptr<const Trail> History::retrace(const Answer& answer) {
  std::shared_ptr<const Trail> retraced = std::exchange(trails_.back(), answer.trail);
  if (!answer.motion()->leaves) trails_.pop_back();
  return retraced;
}

void History::forget() {
  // A motion that never got to the rest that leads back cuts off all before it.
  const auto cut = std::find(trails_.rbegin(), trails_.rend(), nullptr);
  trails_.erase(trails_.begin(), cut.base());
  long ticks = 0;
  auto oldest = trails_.end();
  while (oldest != trails_.begin() && trails_.end() - oldest < kTrails &&
         (ticks += (*std::prev(oldest))->ticks()) <= kTicks)
    --oldest;
  trails_.erase(trails_.begin(), oldest);
}

}  // namespace baton
