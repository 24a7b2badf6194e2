/// Checks a trajectory tick by tick by independent means: finite differences, MuJoCo's inverse dynamics, collision
/// detection and ray casts. It knows robot and world, and shares no code with planner and verifier.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton {

class Checker {
 public:
  enum class Kind {
    not_finite,          ///< a non-finite value
    clock,               ///< time does not advance by one tick [s]
    target,              ///< a joint is off its target [rad]
    joint_range,         ///< joint closer to its limits than the profile's margin [rad]
    joint_speed,         ///< above the profile's limit [rad/s]
    joint_torque,        ///< fraction of stall torque above the profile's, where contact does not make it ambiguous
    joint_acceleration,  ///< above the profile's limit [rad/s²]
    rest,                ///< something moves at rest [m or rad]
    zmp,                 ///< whole-body ZMP margin in the hull of the planned soles below the profile's [m]
    friction,            ///< tangential over vertical ground force; infinite if the ground would have to pull
    self_collision,      ///< links closer to each other than the profile's margin [m]
    obstacle,            ///< a link too close to the world, or a sole to what cannot be stood on [m]
    slip,                ///< a stance sole moves [m]
    swing_ground,        ///< a swing sole is below the ground [m]
    sole_ground,         ///< a stance sole is not on known, flat enough ground [m]
  };
  static constexpr std::array<std::string_view, 15> kNames{
      "not_finite", "clock", "target",   "joint_range",    "joint_speed", "joint_torque", "joint_acceleration",
      "rest",       "zmp",   "friction", "self_collision", "obstacle",    "slip",         "swing_ground",
      "sole_ground"};

  /// Tolerances on the profile's limits. The plan keeps the limits for the desired positions; the executed ones deviate
  /// by the residual of inverse kinematics.
  struct Tolerances {
    double residuals = 2.0;  ///< [the profile's ik residuals] position of a sole or link: two soles' residuals add up
    double sink = 1e-4;      ///< [m] additional penetration of a sole at liftoff and touchdown
    double zmp = 1e-4;       ///< [m] shift of the hull by such a residual
    // Where one motion replaces another, the last acceleration of one and the first of the other add up in one tick.
    double friction = 0.002;  ///< [-]
    double load = 0.002;      ///< [of stall torque]
    double still = 1e-7;      ///< [m or rad] a resting posture is recomputed from its soles
    double exact = 1e-9;      ///< [rad, s] rounding
  };

  /// One tick. `q` is in a level frame, whose pose in the world (position and yaw) is `frame`.
  struct Tick {
    double t = 0.0;  ///< [s]
    Pose frame;
    VecX q;                            ///< configuration (nq)
    BySide<bool> contact{true, true};  ///< planned stance soles
    bool hold = true;                  ///< no motion is under way
    bool catching = false;             ///< a capture step, with laxer margins, is under way
    VecX target;                       ///< joint angles commanded for the next tick (n) [rad]
  };

  struct Violation {
    Kind kind = Kind::not_finite;
    double t = 0.0;  ///< [s]
    double value = 0.0;
    double limit = 0.0;
    std::string where;  ///< joint, geoms or foot; can be empty
  };

  /// @param model_text model of robot and world (MJCF)
  /// @throws InputError the world has joints, or the model lacks a part of the robot
  Checker(const RobotModel& robot, const std::string& model_text, const Tolerances& tolerances);
  Checker(const RobotModel& robot, const std::string& model_text) : Checker(robot, model_text, Tolerances{}) {}

  /// Checks the positions of this tick and the forces of the one before. The result is valid until the next call.
  const std::vector<Violation>& add(const Tick& tick);

 private:
  void report(Kind kind, double t, double value, double limit, std::string where = "");
  void prepare_model();
  void place(const Tick& tick, mjData& data, bool in_world) const;
  [[nodiscard]] Pose sole(Side side, const mjData& data) const;
  void judge_joints(const Tick& tick);
  void judge_step(const Tick& before, const Tick& tick);
  void judge_contacts(const Tick& tick);
  void judge_soles(const Tick& tick);
  void judge_ground(const Tick& tick, Side side);
  void judge_forces(const Tick& before, const Tick& tick, const Tick& after);
  void judge_torques(const Tick& tick, const VecX& force, const VecX& speed, double share);
  [[nodiscard]] std::string geoms(int a, int b) const;

  /// Roles of geoms, bodies and joints.
  struct Parts {
    std::vector<char> of_robot;  ///< by geom
    std::vector<char> of_foot;   ///< by geom
    std::vector<char> ground;    ///< by geom
    BySide<int> foot{-1, -1};    ///< bodies
    std::vector<char> of_leg;    ///< by joint
  };

  const RobotModel* robot_;
  Tolerances tolerance_;
  double place_tolerance_ = 0.0;  ///< [m]
  ModelPtr model_;
  DataPtr world_;   ///< in the world frame, newest tick
  DataPtr forces_;  ///< in the frame of `q`, previous tick
  Parts parts_;
  std::optional<Tick> before_;
  std::optional<Tick> earlier_;
  BySide<std::optional<Pose>> stood_;  ///< touchdown pose of a stance sole, in the frame of `q`
  bool still_ = false;                 ///< nothing changed from `earlier_` to `before_`, and that was judged
  std::vector<Violation> found_;
};

}  // namespace baton
