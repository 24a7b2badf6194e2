/// An episode of a soak test: a fresh robot, a random stick, then retracing; all of it judged. A function of robot,
/// world, plant and seed.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "baton/proving/answer_faults.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/proving/tally.hpp"
#include "baton/run/simulation.hpp"

namespace baton {

/// Settings shared by the episodes of a soak.
struct Trial {
  Simulation::On on = Simulation::On::ideal;
  Modes modes{};
  StateSource state = StateSource::sensors;
  std::uint64_t seed = 0;
  double seconds = 120.0;              ///< driven by the stick; then the robot comes to rest and retraces a few motions
  bool real = false;                   ///< in physics: the plant is `real`, drawn per episode; only falls count then
  const Scenario* scenario = nullptr;  ///< in physics, on top of the plant; no retracing then, and only falls count
  double times = 1.0;                  ///< how many times as large the scenario is
  bool arms = false;                   ///< arms are driven by an `ArmPolicy`
  AnswerFaults answers{};              ///< fault injection, seeded per episode
  std::optional<Calibration> calibration{};  ///< what is known of the robot's sensors, the same in all episodes
};

struct EpisodeResult {
  Tally tally;             ///< of this episode
  nlohmann::json summary;  ///< as in docs/report.md
  long ticks = 0;          ///< total: driven, released and retracing
  VecX q;                  ///< configuration at the last tick
  std::string back;        ///< stick while retracing, as script lines
};

class Episodes {
 public:
  /// `robot` and `world` must outlive this object.
  Episodes(const RobotModel& robot, const World& world, const Trial& trial)
      : robot_(&robot), world_(&world), trial_(trial) {}

  /// Runs one episode; thread-safe. Reports all failures in the result.
  /// @param stop ends the episode at the next tick; the result is then meaningless
  [[nodiscard]] EpisodeResult run(long index, const std::atomic<bool>& stop) const;

  /// The episode's stick as a script for `baton drive`.
  /// @param result its own
  [[nodiscard]] std::string script(long index, const EpisodeResult& result) const;

 private:
  [[nodiscard]] long ticks() const;
  [[nodiscard]] std::unique_ptr<Device> stick(long index) const;

  const RobotModel* robot_;
  const World* world_;
  Trial trial_;
};

}  // namespace baton
