#include "baton/record/durations.hpp"

#include <algorithm>

namespace baton {

nlohmann::json Durations::summary() const {
  std::vector<double> sorted = us_;
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double share) {
    if (sorted.empty()) return 0.0;
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
  };
  return {{"p50", quantile(0.5)},
          {"p99", quantile(0.99)},
          {"max", sorted.empty() ? 0.0 : sorted.back()},
          {"n", sorted.size()}};
}

}  // namespace baton
