/// Checks a trajectory tick by tick by independent means: differences in time, MuJoCo's inverse dynamics, collision
/// detection and rays. It knows robot and world, and shares no code with planner and verifier.
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
    not_finite,          ///< a value that is not finite
    clock,               ///< time does not advance by one period [s]
    target,              ///< a joint is not where it was told to be [rad]
    joint_range,         ///< joint nearer to its limits than the profile's margin [rad]
    joint_speed,         ///< faster than the profile allows [rad/s]
    joint_torque,        ///< share of the stall torque over the profile's, where contact leaves no doubt about it
    joint_acceleration,  ///< more than the profile allows [rad/s²]
    rest,                ///< something moves in hold [m or rad]
    zmp,             ///< of the whole body, nearer to the edge of the planned soles' hull than the profile's margin [m]
    friction,        ///< tangential over vertical force on the ground; infinite where the ground would have to pull
    self_collision,  ///< links nearer to each other than the profile's margin [m]
    obstacle,        ///< a link nearer to the world, or a sole to what may not be stood on [m]
    slip,            ///< a standing sole moves [m]
    swing_ground,    ///< a sole that does not stand is below the ground [m]
    sole_ground,     ///< a standing sole is not on known, flat enough ground [m]
  };
  static constexpr std::array<std::string_view, 15> kNames{
      "not_finite", "clock", "target",   "joint_range",    "joint_speed", "joint_torque", "joint_acceleration",
      "rest",       "zmp",   "friction", "self_collision", "obstacle",    "slip",         "swing_ground",
      "sole_ground"};

  /// What a trajectory may miss a limit by. Limits are those of the profile, which the plan keeps at the places that it
  /// wants; what is executed lies beside them by the residual of inverse kinematics.
  struct Tolerances {
    double residuals = 2.0;   ///< [the profile's ik residuals] place of a sole or link: two soles' residuals add up
    double sink = 1e-4;       ///< [m] beyond that, a sole in the ground where it leaves or meets it
    double zmp = 1e-4;        ///< [m] what such a residual moves the hull by
    double friction = 0.002;  ///< [-] the seam of two motions: accelerations at the end of one and the start of the
    double load = 0.002;      ///< [of stall torque] next act at the same tick
    double still = 1e-7;      ///< [m or rad] a resting posture is worked out anew from its soles
    double exact = 1e-9;      ///< [rad, s] rounding where numbers are handed on
  };

  /// One tick. `q` is in a frame that is level (position and yaw), `frame` its pose in the world.
  struct Tick {
    double t = 0.0;  ///< [s]
    Pose frame;
    VecX q;                            ///< configuration (nq)
    BySide<bool> contact{true, true};  ///< soles that are planned to stand
    bool hold = true;                  ///< no motion is under way
    bool catching = false;             ///< a step that catches the robot, with laxer margins, is
    VecX target;                       ///< where the joints shall be at the next tick (n) [rad]
  };

  struct Violation {
    Kind kind = Kind::not_finite;
    double t = 0.0;  ///< [s]
    double value = 0.0;
    double limit = 0.0;
    std::string where;  ///< joint, geoms or foot; may be empty
  };

  /// @param model_text world and robot in one model (MJCF)
  /// @throws InputError the world has joints of its own, or the model lacks a part of the robot
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

  /// What the parts of the model are.
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
  DataPtr world_;   ///< placed in the world, at the newest tick
  DataPtr forces_;  ///< placed in the frame of `q`, at the tick before
  Parts parts_;
  std::optional<Tick> before_;
  std::optional<Tick> earlier_;
  BySide<std::optional<Pose>> stood_;  ///< where a standing sole began to stand, in the frame of `q`
  bool still_ = false;                 ///< nothing has changed from `earlier_` to `before_`, and that was judged
  std::vector<Violation> found_;
};

}  // namespace baton
