/// Terrain adaptation and foot admittance: the legs follow where the soles actually are and how they are tilted, and
/// comply with excess contact forces, so that the trunk stays where it was planned (docs/balance.md).
#pragma once

#include <optional>

#include "baton/balance/ground_compliance.hpp"
#include "baton/balance/state.hpp"

namespace baton {

class Footing {
 public:
  /// The robot must outlive the object.
  explicit Footing(const RobotModel& robot);

  /// Updates the offsets, once a tick.
  /// @param now planned sample at the time of the measurement
  /// @param next planned sample one tick later
  /// @param wanted desired wrench on each sole, in the axes of the planning frame, moment about its centre
  void follow(const MotionSample& now, const MotionSample& next, const State& state, const BySide<Wrench>& wanted);

  /// Joint angles that place the soles at their offsets, within the joints' ranges.
  /// @param kinematics set to the planned configuration; changed
  /// @param q planned configuration (nq)
  /// @param joints receives the angles (n)
  void apply(Kinematics& kinematics, const VecX& q, VecX& joints);

  /// Displacement of a sole from its planned pose, in the planning frame.
  struct Offset {
    Vec3 p = Vec3::Zero();     ///< [m]
    Vec3 turn = Vec3::Zero();  ///< rotation vector [rad]
  };
  [[nodiscard]] const BySide<Offset>& offset() const { return offset_; }

 private:
  /// Fraction of an error that is corrected in one tick, for a rate in ω.
  [[nodiscard]] double share_of(double rate) const { return std::min(1.0, period_ * rate); }
  /// Updates the offset of a sole that is loaded.
  /// @param carries gain by the load, 0…1
  void follow_ground(Side side, double carries, const MotionSample& now, const State& state, const Wrench& wanted);

  /// Raises a sole that found the ground by searching, and presses on it too much, to the ground's height. Contact is
  /// known late and servos lag: the leg has gone too far, and would push the robot over.
  void withdraw(Side side, const MotionSample& now, const State& state, const Wrench& wanted);

  /// The offset by which a sole in the air is as high as planned, and inclined as planned relative to the floor,
  /// although the trunk that carries it is off its plan. To the side and ahead the sole moves with the trunk.
  [[nodiscard]] Offset levelled(Side side, const MotionSample& now, const State& state) const;

  /// Updates `rocking_` and `uneven_`, at rest on both feet.
  void feel_rocking(const State& state, const BySide<Wrench>& wanted);
  /// Factor by which an ankle turns farther for the same moment where it stands on soft ground: 1 on firm ground.
  [[nodiscard]] double ground_gain() const;

  /// Moves the soles apart or together, to relax internal forces between the legs.
  void relax(const State& state, const BySide<Wrench>& wanted);

  /// Excess moment on a sole.
  struct Tipping {
    Vec2 moment = Vec2::Zero();  ///< beyond the dead band [weight × COM height]
    double duration = 0.0;       ///< time for which its direction has been about the same [1/ω]
  };

  /// One Levenberg–Marquardt step of `shifted_`, which `kinematics` is set to. Returns whether the sole had converged.
  bool step_towards(Side side, const Pose& goal, const Kinematics& kinematics, const VecX& q);
  /// `angle` clamped to the joint's range inset by `margin.joint`, extended to the planned angle [rad].
  [[nodiscard]] double within_range(int joint, double planned, double angle) const;

  /// By how much the trunk must be lowered so that a leg is not stretched beyond its planned length [m]. Length is
  /// from its first to its last joint. The leg may be straight in the plan.
  [[nodiscard]] double trunk_drop(Side side, const Kinematics& kinematics) const;

  const RobotModel* robot_;
  double period_;      ///< [1/ω]
  double height_;      ///< nominal COM height [m]
  double half_width_;  ///< of a sole [m]
  double weight_;      ///< [N]
  double ankle_kp_;    ///< kp of the stiffer ankle [weight × COM height/rad]
  double softness_;    ///< factor on all compliance, less than 1 with stiff servos
  GroundCompliance ground_;
  std::vector<int> legs_;  ///< links of the legs
  JacobianRows columns_;   ///< Jacobian of a sole, of its leg's joints (6 × n)
  VecX shift_;             ///< latest change of the joint angles (n) [rad]
  VecX shifted_;           ///< planned configuration with that change (nq)
  BySide<Offset> offset_;
  BySide<Tipping> tipping_;
  double age_ = 0.0;                ///< of the measurements, low-passed [1/ω]
  std::optional<double> uneven_;    ///< excess load of the left sole less that of the right, low-passed [weights]
  double rocking_ = 0.0;            ///< mean square of the load that rocks from sole to sole at rest [weights²]
  double compliance_ = 1.0;         ///< factor on all compliance, by stiffness, age and rocking
  Vec2 floor_tilt_ = Vec2::Zero();  ///< tilt of the terrain relative to the map: `turn` of flat soles, low-passed [rad]
  BySide<bool> overreaches_{false, false};  ///< whether a search may have sent the sole too far down
  BySide<double> missing_time_{0.0, 0.0};   ///< time for which an expected contact has been missing [1/ω]
};

}  // namespace baton
