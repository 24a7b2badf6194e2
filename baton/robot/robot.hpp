/// Port for everything that has joints and sensors: an ideal robot, a simulated one, a real one.
#pragma once

#include <stdexcept>
#include <string>

#include "baton/balance/measurement.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// What only a simulation knows: for traces, reports and judges, never for control.
struct Truth {
  double t = 0.0;
  VecX q;               ///< configuration (nq) in the order of the robot's model
  VecX dq;              ///< (nv)
  BySide<Wrench> sole;  ///< from the ground, in the world, about its origin
  BySide<bool> touch{false, false};
  bool fallen = false;
  std::string fall;  ///< why it counts as fallen
};

class Robot {
 public:
  virtual ~Robot() = default;

  /// What the sensors say now.
  [[nodiscard]] virtual Measurement read() = 0;

  /// Where the joints shall be when the tick ends. A simulated robot lives through the tick in this call.
  virtual void write(const JointTarget& target) = 0;

  /// Back to the start posture, as if newly constructed, random sources included.
  /// @throws std::logic_error it cannot, like a real robot, which somebody has to carry back
  virtual void reset() { throw std::logic_error("this robot cannot be put back to its start"); }

  /// What a simulation knows, up to date after each `write`; null for a robot that has none, like a real one.
  [[nodiscard]] virtual const Truth* truth() const { return nullptr; }
};

}  // namespace baton
