/// Play (backlash) between motors, with the encoders on them, and the links that they drive: under load, a motor is at
/// that end of the play towards which its torque pushes. The size of the play shows in double support, where the soles
/// stand still but encoders turn as load passes from one leg to the other (docs/balance.md).
#pragma once

#include "baton/balance/sole_contact.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class JointPlay {
 public:
  /// The robot must outlive the object.
  explicit JointPlay(const RobotModel& robot);

  /// Takes the play out of the joint angles, and learns its size; once a tick.
  /// @param q joint angles by the encoders, corrected in place (n) [rad]
  /// @param torque motor torques (n) [N·m]; empty: not measured, so nothing is corrected
  /// @param planned planned contacts
  void correct(VecX& q, const VecX& torque, const SoleContact& contact, const BySide<bool>& planned);

  /// Estimated play to each side, the same for all joints [rad].
  [[nodiscard]] double estimate() const;

 private:
  struct State {
    VecX q;     ///< joint angles by the encoders [rad]
    VecX side;  ///< where each motor is in its play: −1 to 1
  };

  /// Corrects the estimate by a double support from `begin_` to `latest_`.
  void learn();
  /// Displacement of the right sole in the left sole's frame between the two, for joints with this play [m].
  [[nodiscard]] Vec3 moved(double play);

  const RobotModel* robot_;
  double follows_;  ///< fraction of a change of side that is followed in a tick
  Kinematics kinematics_;
  VecX configuration_;
  VecX end_;  ///< end of the play at which each motor was last: −1 or 1; 0: not known yet
  State latest_;
  State begin_;
  long ticks_ = 0;     ///< of the double support so far
  double play_ = 0.0;  ///< that explains the soles' displacements best [rad]
  double trust_;       ///< squared displacements by play that it rests on [m²/rad²]
};

}  // namespace baton
