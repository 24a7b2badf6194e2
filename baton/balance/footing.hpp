/// Where the soles really are and how they are inclined, against the plan: followed by the legs, so that the trunk
/// stays where it was planned (docs/balance.md).
#pragma once

#include "baton/balance/state.hpp"

namespace baton {

class Footing {
 public:
  /// The robot must outlive the object.
  explicit Footing(const RobotModel& robot);

  /// Brings the offsets up to date, once a tick.
  /// @param now planned sample at the time of the measurement
  /// @param next planned sample a tick later
  /// @param wanted what each sole should carry then, axes of the planning frame, moment about its centre
  void follow(const MotionSample& now, const MotionSample& next, const State& state, const BySide<Wrench>& wanted);

  /// Joint angles that take the soles there; within the joints' ranges.
  /// @param kinematics set to the planned configuration; left at another one
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
  /// Rates are [1/s], the same for any size of robot.
  struct Rates {
    double height = 15.0;      ///< at which the height of a sole that carries is followed
    double early = 30.0;       ///< the same of a foot on its way down, whose ground comes early
    double early_trust = 0.0;  ///< share of those rates with which that begins, be its load as small as it may
    double late = 0.6;         ///< at which a foot that should carry looks for ground farther down [COM heights/s]
    double place = 8.0;        ///< its horizontal place
    double turn = 8.0;         ///< its inclination
    double relax = 1.0;       ///< [COM heights/s] by a force of the weight with which the legs press against each other
    double untwist = 2.0;     ///< [rad/s] by such a moment about the vertical of weight × COM height
    double yield_turn = 8.0;  ///< [rad/s] by a moment too much of weight × COM height
    double yield_height = 0.2;  ///< [COM heights/s] by a force too much of the weight
    double yield_early = 0.2;   ///< the same of a foot on its way down
    double band_turn = 0.04;    ///< pressure that is off by less is not yielded to [COM height]
    double band_height = 0.1;   ///< nor is force [weight]
  };
  [[nodiscard]] static Rates rates_for(Drive drive);
  [[nodiscard]] double share_of(double rate) const { return std::min(1.0, period_ * rate); }
  void follow_ground(Side side, double carries, const MotionSample& now, const State& state, const Wrench& wanted);

  /// Lets the soles go apart, or together, until the legs no longer press against each other.
  void relax(const State& state, const BySide<Wrench>& wanted);

  /// A moment that a sole is to yield to.
  struct Tipping {
    Vec2 last = Vec2::Zero();  ///< [weight × COM height]
    double lasts = 0.0;        ///< for how long it has had about this direction [s]
  };

  /// One step of Levenberg–Marquardt with `shifted_`, at which the kinematics are; whether the sole was there already.
  bool reach(Side side, const Pose& goal, const Kinematics& kinematics, const VecX& q);
  /// A joint's angle, kept inside its range: `margin.joint` inside it, or as near to its end as is planned [rad].
  [[nodiscard]] double within_range(int joint, double planned, double angle) const;

  /// How far the trunk must come down for a leg, which might be straight, not to be stretched beyond what was
  /// planned [m], from its first to its last joint.
  [[nodiscard]] double stretched(Side side, const Kinematics& kinematics) const;

  const RobotModel* robot_;
  Rates rates_;
  double period_;
  double height_;  ///< of the COM, nominal [m]
  double weight_;  ///< [N]
  JacobianRows rows_;
  VecX shift_;    ///< of the joint angles, at last (n)
  VecX shifted_;  ///< configuration (nq)
  BySide<Offset> offset_;
  BySide<Tipping> tipping_;
  Vec2 floor_ = Vec2::Zero();  ///< how the floor is inclined, against the map: `turn` of soles that lie flat, slowly
  BySide<double> missed_{0.0, 0.0};  ///< for how long a sole should have carried, and did not [s]
};

}  // namespace baton
