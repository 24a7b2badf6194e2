/// Play (backlash) between motors, with the encoders on them, and the links that they drive: a motor is at that end of
/// the play towards which its torque pushes, or on the way there, with no more than its rotor to accelerate. The size
/// of the play shows in double support, where the soles stand still but encoders turn as load passes from one leg to
/// the other (docs/balance.md).
#pragma once

#include <vector>

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

  /// Moves each motor within its play by its torque. Returns whether one of the legs' is crossing.
  bool cross(const VecX& torque);
  /// Corrects the estimate by a double support from `begin_` to `end_`.
  void learn();
  /// Displacement of the right sole in the left sole's frame between the two, for joints with this play [m].
  [[nodiscard]] Vec3 moved(double play);

  const RobotModel* robot_;
  Kinematics kinematics_;
  VecX configuration_;
  std::vector<int> legs_;  ///< their joints
  VecX speed_;             ///< of each motor within its play (n) [rad/s]
  State latest_;
  State begin_;  ///< of the double support; no motor is crossing there, nor at its end
  State end_;
  bool stood_ = false;  ///< whether both soles stood still in the last tick
  bool begun_ = false;  ///< whether `begin_` and `end_` are of this double support
  int settled_ = 0;     ///< for how long no motor of the legs has been crossing [ticks]
  double play_ = 0.0;   ///< that explains the soles' displacements best [rad]
  double trust_;        ///< squared displacements by play that it rests on [m²/rad²]
};

}  // namespace baton
