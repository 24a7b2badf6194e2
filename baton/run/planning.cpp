#include "baton/run/planning.hpp"

#include <utility>

#include "baton/run/cpu_time.hpp"

namespace baton {

void DirectPlanning::post(Request request) {
  const double before = cpu_us();
  Answer answer = strategy_.plan(request);
  ready_ = {std::move(request), std::move(answer), cpu_us() - before};
}

std::optional<Planning::Reply> DirectPlanning::poll(long /*tick*/) {
  return std::exchange(ready_, std::nullopt);
}

}  // namespace baton
