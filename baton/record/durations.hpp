/// Collects durations and summarises them by quantiles.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

namespace baton {

class Durations {
 public:
  void add(double us) { us_.push_back(us); }
  /// {"p50", "p99", "max", "n"}, in µs.
  [[nodiscard]] nlohmann::json summary() const;

 private:
  std::vector<double> us_;
};

}  // namespace baton
