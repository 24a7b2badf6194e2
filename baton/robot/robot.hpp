/// Interface to a robot: ideal, simulated or real.
#pragma once

#include <stdexcept>
#include <string>

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Ground truth of a simulation, for traces, reports, judges, and an operator that watches the robot from outside;
/// never for control.
struct Truth {
  double t = 0.0;
  VecX q;               ///< configuration (nq), ordered as in the robot's model
  VecX dq;              ///< (nv)
  BySide<Wrench> sole;  ///< ground reaction wrench in the world frame, about the world origin
  BySide<bool> touch{false, false};
  bool fallen = false;
  std::string fall;  ///< how the fall was detected
};

class Robot {
 public:
  virtual ~Robot() = default;

  /// Current sensor readings.
  [[nodiscard]] virtual Measurement read() = 0;

  /// Sends the joint targets for the end of this tick. A simulated robot advances by one tick in this call.
  virtual void write(const JointTarget& target) = 0;

  /// Returns to the state after construction, including random number generators.
  /// @throws std::logic_error not supported, as on a real robot
  virtual void reset() { throw std::logic_error("this robot cannot be reset to its start"); }

  /// Ground truth, updated by each `write`; null if there is none, as on a real robot.
  [[nodiscard]] virtual const Truth* truth() const { return nullptr; }
};

}  // namespace baton
