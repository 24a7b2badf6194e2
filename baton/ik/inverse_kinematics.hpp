/// Body-part targets → joint angles (docs/theory.md §5).
///
/// Feet and COM are held as good as exactly; trunk attitude and hands as well as they can be beside them. One
/// Newton step is the minimiser of
///     Σ_rows (J dq − e)² / R + (dq − dq_ref)ᵀ D (dq − dq_ref),
/// with R a small constant on feet and COM and R = r + eᵀe (error damping) on the rest; its dual form is a
/// system of as many unknowns as there are rows. Only if that step breaks a position or speed bound is the same
/// cost minimised under the bounds, by a quadratic program, so that no joint is ever frozen at a bound.
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "baton/model/kinematics.hpp"

namespace baton {

/// Where the body parts should be. A target that is not finite is ignored: its part keeps its place.
struct IkTargets {
  Vec3 com = Vec3::Zero();
  Mat3 trunk = Mat3::Identity();
  BySide<Pose> sole;
  /// World pose of a hand (its position only, where the arm has fewer than six joints); an arm without one
  /// follows `arms`.
  BySide<std::optional<Pose>> hand;
  VecX arms;  ///< angles by joint of the model (n); those of the arms count [rad]
};

/// What is left between targets and result.
struct IkResidual {
  double sole_position = 0.0;  ///< worst of both soles [m]
  double sole_rotation = 0.0;  ///< [rad]
  double com = 0.0;            ///< [m]
  double trunk = 0.0;          ///< [rad]
  double hand = 0.0;           ///< worst of both hands' positions [m]
};

struct IkResult {
  IkResidual residual;
  int iterations = 0;
  int bound_joint = -1;        ///< a joint at its position or speed bound, −1 if none is
  bool finite_targets = true;  ///< false: at least one target was ignored
};

class InverseKinematics {
 public:
  /// Metres count as much as radians, for any size of robot.
  struct Parameters {
    double hard_damping = 1e-6;   ///< R of feet and COM [-]
    double trunk_damping = 1e-5;  ///< r of the trunk's attitude [-]
    double hand_damping = 1e-4;   ///< r of the hands [-]
    double rest_gain = 0.1;       ///< share of the way home that joints of neither leg nor arm go each step [-]
    double largest_step = 0.2;    ///< errors are shortened to this [m], [rad]
    double tolerance = 1e-7;      ///< of feet and COM at which the iteration ends [m], [rad]
  };

  /// The model must outlive the object.
  explicit InverseKinematics(const RobotModel& robot);
  InverseKinematics(const RobotModel& robot, Parameters parameters);
  ~InverseKinematics();

  /// A pure function of its arguments.
  /// @param previous configuration (nq) from which speed bounds count
  /// @param dt time since `previous` [s]; infinite: no speed bounds
  /// @param q in: where to linearise first (nq); out: the solution, within position and speed bounds
  /// @param iterations largest number of Newton steps
  IkResult solve(const IkTargets& targets, const VecX& previous, double dt, VecX& q, int iterations);

  /// Kinematics at the last solution.
  [[nodiscard]] const Kinematics& kinematics() const { return kinematics_; }

 private:
  struct Workspace;

  /// Errors of all tasks where the links are now.
  void measure(const IkTargets& targets, IkResult& result);
  /// Jacobians of the same tasks, in the same order.
  void linearise(const IkTargets& targets);
  void free_step();
  void bounded_step();

  const RobotModel* robot_;
  Parameters parameters_;
  Kinematics kinematics_;
  std::unique_ptr<Workspace> w_;
};

}  // namespace baton
