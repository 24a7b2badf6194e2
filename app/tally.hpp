/// What many episodes of a soak add up to, and what follows for the rate of failures.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace baton::app {

/// Upper end of the one-sided 95 % confidence interval for the rate of failures, after `failures` in `trials`
/// independent trials (Clopper and Pearson): the largest rate at which so few would be seen in 5 % of such runs. 1
/// without a trial.
[[nodiscard]] double failure_rate_95(long failures, long trials);

/// Sums over whole episodes.
struct Tally {
  /// Something that must not happen.
  struct Failure {
    std::string kind;  ///< of violation (docs/soak.md), `fall`, `stuck` or `exception`
    long episode = 0;
    double t = 0.0;  ///< from the episode's start [s]
    double value = 0.0;
    double limit = 0.0;
    std::string where;
  };
  static constexpr std::size_t kListed = 100;  ///< failures that are kept one by one

  long episodes = 0;
  long ticks = 0;
  long deflected = 0;  ///< ticks with the stick deflected
  long segments = 0;   ///< committed
  long shrunk = 0;     ///< of these, only a part of what was asked for
  std::map<std::string, long> refused;
  long given = 0;  ///< commands, as docs/report.md counts them
  long moved = 0;
  double travel = 0.0;              ///< [m]
  std::map<std::string, long> bad;  ///< failures by kind; each kind once a segment at most
  long failures = 0;                ///< segments with at least one of them
  std::vector<Failure> listed;      ///< the first ones

  void add(const Tally& other);

  [[nodiscard]] nlohmann::json json() const;
  /// @throws nlohmann::json::exception it is not what `json()` wrote
  [[nodiscard]] static Tally from_json(const nlohmann::json& json);
};

}  // namespace baton::app
