/// An episode of a soak: a fresh robot, a random stick, the way back, all of it judged. A function of robot, world,
/// plant and seed.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "baton/proving/answer_faults.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/proving/tally.hpp"
#include "baton/run/simulation.hpp"

namespace baton {

/// What the episodes of a soak have in common.
struct Trial {
  Simulation::On on = Simulation::On::ideal;
  Modes modes{};
  StateSource state = StateSource::sensors;
  std::uint64_t seed = 0;
  double seconds = 120.0;              ///< with the stick; then it comes to rest, and goes a few motions back
  const Scenario* scenario = nullptr;  ///< in physics, with a plant for each episode; there is no way back then
  double times = 1.0;                  ///< factor on how far that is from the model
  AnswerFaults answers{};              ///< what goes wrong with them, by the seed of each episode
};

struct EpisodeResult {
  Tally tally;             ///< of this episode
  nlohmann::json summary;  ///< as docs/report.md has it
  long ticks = 0;          ///< all of them: driven, let go, and on the way back
  VecX q;                  ///< configuration at the last of them
  std::string back;        ///< what was pressed on the way back, as lines of a script
};

class Episodes {
 public:
  /// Robot and world must outlive the object.
  Episodes(const RobotModel& robot, const World& world, const Trial& trial)
      : robot_(&robot), world_(&world), trial_(trial) {}

  /// Drives one; for any number of threads at a time. Everything that goes wrong is in the result.
  /// @param stop ends it at the next tick; the result is of no use then
  [[nodiscard]] EpisodeResult run(long index, const std::atomic<bool>& stop) const;

  /// The stick of an episode as a script for `baton drive`.
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
