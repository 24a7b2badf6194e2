/// Totals over the episodes of a soak, and a confidence bound on the failure rate.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "baton/input/json_reader.hpp"

namespace baton {

/// Upper one-sided 95 % confidence bound on the failure rate after `failures` in `trials` independent trials
/// (Clopper-Pearson): the largest rate at which so few failures have a probability of 5 %. 1 without trials.
[[nodiscard]] double failure_rate_95(long failures, long trials);

/// Sums over whole episodes.
struct Tally {
  /// An event that must not happen.
  struct Failure {
    std::string kind;  ///< kind of violation, `fall`, `unrest` … (docs/soak.md)
    long episode = 0;
    double t = 0.0;  ///< from the episode's start [s]
    double value = 0.0;
    double limit = 0.0;
    std::string where;
  };
  static constexpr std::size_t kListed = 100;  ///< most failures kept individually

  /// Retraces at the ends of episodes, by motion.
  struct Retrace {
    long tried = 0;
    long arrived = 0;  ///< ended where the robot had rested
    long refused = 0;
    double worst_m = 0.0;    ///< largest position error of COM or sole there
    double worst_rad = 0.0;  ///< largest rotation error of the trunk there
  };

  /// Arms that are driven from outside, and not by the stick, in ticks of each arm.
  struct Arms {
    long driven = 0;
    long on_target = 0;  ///< with all joints within 0.05 rad of their targets
  };

  long episodes = 0;
  long ticks = 0;
  long deflected = 0;  ///< ticks with the stick deflected
  long segments = 0;   ///< committed segments
  long shrunk = 0;     ///< of these, shrunk
  long let_go = 0;     ///< of these, with the stick released on the way
  std::map<std::string, long> refused;
  long given = 0;  ///< commands, counted as in docs/report.md
  long moved = 0;
  double travel = 0.0;  ///< [m]
  Retrace retrace;
  Arms arms;
  std::map<std::string, long> bad;  ///< failures by kind; each kind at most once per segment
  long failures = 0;                ///< segments with at least one failure
  std::vector<Failure> listed;      ///< first failures

  void add(const Tally& other);

  [[nodiscard]] nlohmann::json json() const;
  /// @throws InputError not written by `json()`
  [[nodiscard]] static Tally from_json(const JsonReader& read);
};

}  // namespace baton
