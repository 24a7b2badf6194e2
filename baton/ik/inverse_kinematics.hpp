/// Body-part targets → joint angles (docs/theory.md §5).
///
/// Soles and COM are met almost exactly, trunk attitude and hands as well as that allows. A Newton step minimises
///     Σ_rows (J dq − e)² / R + (dq − dq_ref)ᵀ D (dq − dq_ref),
/// with a small constant R for soles and COM, and R = r + eᵀe (error damping) for the rest. It is solved in the dual
/// form, with one unknown per row. If the step violates a position or speed bound, the same cost is minimised subject
/// to all bounds by a quadratic program. Joints are not frozen at bounds: that could make the soles and the COM
/// unreachable. Joints of neither leg nor arm keep their home angle: the trunk turns as the pelvis does.
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "baton/model/kinematics.hpp"

namespace baton {

/// Targets of the body parts. One that is not finite is ignored: its part keeps its pose.
struct IkTargets {
  Vec3 com = Vec3::Zero();
  Mat3 trunk = Mat3::Identity();
  BySide<Pose> sole;
  /// Pose of a hand; only its position counts if the arm has fewer than six joints. An arm without one follows `arms`.
  BySide<std::optional<Pose>> hand;
  VecX arms;  ///< joint angles (n); only those of arms are used [rad]
};

/// Remaining errors.
struct IkResidual {
  double sole_position = 0.0;  ///< larger one of both soles [m]
  double sole_rotation = 0.0;  ///< the same [rad]
  double com = 0.0;            ///< [m]
  double trunk = 0.0;          ///< [rad]
  double hand = 0.0;           ///< position, larger one of both hands [m]
};

struct IkResult {
  IkResidual residual;
  int iterations = 0;
  int bound_joint = -1;        ///< a joint at its position or speed bound, −1 if none
  bool finite_targets = true;  ///< false: at least one target was ignored
};

class InverseKinematics {
 public:
  /// One metre weighs as much as one radian, for robots of any size.
  struct Parameters {
    double hard_damping = 1e-6;   ///< R of soles and COM [-]
    double trunk_damping = 1e-5;  ///< r of the trunk attitude [-]
    double hand_damping = 1e-4;   ///< r of the hands [-]
    double largest_step = 0.2;    ///< errors are clamped to this norm [m], [rad]
    double tolerance = 1e-7;      ///< errors of soles and COM at which the iteration ends [m], [rad]
  };

  /// The model must outlive the object.
  explicit InverseKinematics(const RobotModel& robot);
  InverseKinematics(const RobotModel& robot, Parameters parameters);
  ~InverseKinematics();

  /// Solves for the configuration. The result depends on the arguments only.
  /// @param previous configuration that speed bounds are relative to (nq)
  /// @param dt time since `previous` [s]; infinite: no speed bounds
  /// @param q in: initial guess; out: solution, within position and speed bounds (nq)
  /// @param iterations largest number of Newton steps
  IkResult solve(const IkTargets& targets, const VecX& previous, double dt, VecX& q, int iterations);

  /// Kinematics at the latest solution.
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }

 private:
  struct Workspace;

  /// Errors of all tasks at the current configuration.
  void measure(const IkTargets& targets, IkResult& result);
  /// Jacobians of the tasks, in the order of `measure`.
  void linearise(const IkTargets& targets);
  void free_step();
  void bounded_step();

  const RobotModel* robot_;
  Parameters parameters_;
  Kinematics kinematics_;
  std::unique_ptr<Workspace> w_;
};

}  // namespace baton
