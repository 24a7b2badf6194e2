/// A stretch of a soak: a fresh robot, a stick at random, the way back, and judges. It is a function of robot, world,
/// plant and seed.
#pragma once

#include <atomic>

#include "app/checker.hpp"
#include "app/session.hpp"
#include "app/stick.hpp"
#include "app/tally.hpp"

namespace baton::app {

struct EpisodeResult {
  Tally tally;       ///< of this episode
  long ticks = 0;    ///< all of them: driven, let go, and on the way back
  VecX q;            ///< configuration at the last of them
  std::string back;  ///< what was pressed on the way back, as lines of a script
};

class Episodes {
 public:
  /// @param seconds each is that long [s], and then until the robot rests, and a few motions back
  Episodes(const RobotModel& robot, const World& world, Session::On on, Modes modes, std::uint64_t seed,
           double seconds);

  /// Drives one; for any number of threads at a time. Everything that goes wrong is in the result.
  /// @param stop ends it at the next tick; the result is of no use then
  [[nodiscard]] EpisodeResult run(long index, const std::atomic<bool>& stop) const;

  /// The stick of an episode as a script for `baton drive`.
  /// @param result its own
  [[nodiscard]] std::string script(long index, const EpisodeResult& result) const;

 private:
  const RobotModel* robot_;
  const World* world_;
  Session::On on_;
  Modes modes_;
  std::uint64_t seed_;
  long ticks_;
};

/// Whether no command at all, of many different ones and the way back, has a motion from there.
/// @param problem from where the robot rests; its command does not matter
[[nodiscard]] bool stuck(Planning& planning, Problem problem);

}  // namespace baton::app
