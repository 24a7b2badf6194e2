/// Totals over the episodes of a soak, and the confidence bound for the rate of failures.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "baton/input/json_reader.hpp"

namespace baton {

/// Upper end of the one-sided 95 % confidence interval for the rate of failures, after `failures` in `trials`
/// independent trials (Clopper and Pearson): the largest rate at which so few would be seen in 5 % of such runs. 1
/// without a trial.
[[nodiscard]] double failure_rate_95(long failures, long trials);

/// Sums over whole episodes.
struct Tally {
  /// Something that must not happen.
  struct Failure {
    std::string kind;  ///< of violation (docs/soak.md), `fall`, `stuck`, `retrace` or `exception`
    long episode = 0;
    double t = 0.0;  ///< from the episode's start [s]
    double value = 0.0;
    double limit = 0.0;
    std::string where;
  };
  static constexpr std::size_t kListed = 100;  ///< failures that are kept one by one

  /// Ways back at the ends of episodes, motion by motion.
  struct Retrace {
    long tried = 0;
    long arrived = 0;  ///< where the robot rested before
    long refused = 0;
    double worst_m = 0.0;    ///< a COM or sole away from there
    double worst_rad = 0.0;  ///< the trunk turned from there
  };

  long episodes = 0;
  long ticks = 0;
  long deflected = 0;  ///< ticks with the stick deflected
  long segments = 0;   ///< committed
  long shrunk = 0;     ///< of these, only a part of what was asked for
  long let_go = 0;     ///< of these, with the stick let go of on the way
  std::map<std::string, long> refused;
  long given = 0;  ///< commands, as docs/report.md counts them
  long moved = 0;
  double travel = 0.0;  ///< [m]
  Retrace retrace;
  std::map<std::string, long> bad;  ///< failures by kind; each kind once a segment at most
  long failures = 0;                ///< segments with at least one of them
  std::vector<Failure> listed;      ///< the first ones

  void add(const Tally& other);

  [[nodiscard]] nlohmann::json json() const;
  /// @throws InputError it is not what `json()` wrote
  [[nodiscard]] static Tally from_json(const JsonReader& read);
};

}  // namespace baton
