/// Kinematics and dynamics of a robot at one configuration: a scratch pad, one for each thread.
#pragma once

#include "baton/model/robot_model.hpp"

namespace baton {

/// Rows are stored one after the other, so that a task's rows can be written in place.
using JacobianRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class Kinematics {
 public:
  /// The model must outlive the object.
  explicit Kinematics(const RobotModel& robot);

  /// Places all links; everything below speaks of this configuration. `q`: nq, finite, quaternion of any norm.
  void set(const VecX& q);

  [[nodiscard]] const RobotModel& robot() const { return *robot_; }
  [[nodiscard]] Vec3 com() const;
  [[nodiscard]] Pose trunk() const { return body(robot_->trunk_body()); }
  [[nodiscard]] Pose sole(Side side) const { return body(robot_->foot_body(side)) * robot_->sole_in_foot(side); }
  [[nodiscard]] Pose hand(Side side) const { return body(robot_->hand_body(side)) * robot_->hand_in_body(side); }
  [[nodiscard]] Vec3 shoulder(Side side) const { return body(robot_->shoulder_body(side)).p; }
  [[nodiscard]] const Pose& body(int id) const { return link_[static_cast<std::size_t>(id)]; }

  /// What a link turns about, in the world.
  struct Axis {
    Vec3 direction;  ///< unit
    Vec3 point;      ///< on the axis [m]
  };
  /// Of a degree of freedom but the first three, which shift the root.
  [[nodiscard]] const Axis& dof_axis(int dof) const { return axis_[static_cast<std::size_t>(dof)]; }

  /// Jacobian of the COM, written to `rows` (3 × nv). docs/theory.md §5.
  void com_jacobian(Eigen::Ref<JacobianRows> rows) const;
  /// Jacobian of a point [m, world] fixed to a body: velocity of the point (3 × nv).
  void point_jacobian(int body, const Vec3& point, Eigen::Ref<JacobianRows> rows) const;
  /// Jacobian of a body's angular velocity in the world (3 × nv).
  void rotation_jacobian(int body, Eigen::Ref<JacobianRows> rows) const;

  /// Both of a sole: velocity of its centre, angular velocity (6 × nv).
  void sole_jacobian(Side side, Eigen::Ref<JacobianRows> rows) const;

  /// Generalised forces that the links need for (q, q̇, q̈) with nothing touching them: gravity, inertia and
  /// the motors' reflected inertia; without damping. Also sets the configuration.
  /// [N, N·m], nv: force on the trunk in the world 3, moment about its origin in the trunk 3, joints.
  void inverse_dynamics(const VecX& q, const VecX& dq, const VecX& ddq, VecX& force);

  /// Least distance of the pairs of geoms that the model names for self-collision [m], as far as it is less
  /// than `limit`; `limit` otherwise. `geoms` receives the nearest pair.
  [[nodiscard]] double self_distance(double limit, std::array<int, 2>* geoms = nullptr) const;

 private:
  /// Sums up what the links and all that hang on them weigh, once it is asked for.
  void weigh() const;
  /// Sets MuJoCo's data to the configuration, once they are needed: that takes longer than all of the above.
  void place() const;

  const RobotModel* robot_;
  DataPtr data_;
  VecX q_;
  std::vector<std::optional<Mat3>> turned_;  ///< of each link in its parent, all joints at zero; none: not turned
  std::vector<Mat3> principal_;              ///< axes of inertia of each link in it
  std::vector<Pose> link_;
  std::vector<Axis> axis_;             ///< by degree of freedom
  mutable std::vector<Vec3> subtree_;  ///< mass × COM of each link with all that hang on it [kg m]
  mutable bool weighed_ = false;
  mutable bool placed_ = false;
};

/// Puts the root at a pose; `q`: nq.
void set_root(VecX& q, const Pose& root);

/// q ⊕ dq·dt: integrates a velocity (nv) over a time.
void integrate(const RobotModel& robot, VecX& q, const VecX& dq, double dt);

/// (b ⊖ a)/dt: the velocity that leads from a to b.
void difference(const RobotModel& robot, VecX& dq, double dt, const VecX& a, const VecX& b);

}  // namespace baton
