/// Kinematics and dynamics of a robot at one configuration. Not thread-safe: use one object per thread.
#pragma once

#include "baton/model/robot_model.hpp"

namespace baton {

/// Row-major, so that the rows of a task can be written in place.
using JacobianRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// "World" means the frame in which `q` gives the root pose.
class Kinematics {
 public:
  /// The model must outlive the object.
  explicit Kinematics(const RobotModel& robot);

  /// Sets the configuration of everything below.
  /// @param q configuration (nq), finite, its quaternion of any norm
  void set(const VecX& q);
  /// The same, if the robot is that of `other`, moved as a whole: without its joints, that is quicker.
  /// @param by displacement, in the world
  /// @param q as it is then
  void set_moved(const Kinematics& other, const Pose& by, const VecX& q);
  /// The same, if only the joints of some links have changed since: without the others, that is quicker.
  /// @param links bodies, those that they carry too, each after its parent
  void set_links(const VecX& q, const std::vector<int>& links);

  [[nodiscard]] const RobotModel& robot() const { return *robot_; }
  [[nodiscard]] Vec3 com() const;
  [[nodiscard]] Pose trunk() const { return body(robot_->trunk_body()); }
  [[nodiscard]] Pose sole(Side side) const { return body(robot_->foot_body(side)) * robot_->sole_in_foot(side); }
  [[nodiscard]] Pose hand(Side side) const { return body(robot_->hand_body(side)) * robot_->hand_in_body(side); }
  [[nodiscard]] Vec3 shoulder(Side side) const { return body(robot_->shoulder_body(side)).p; }
  [[nodiscard]] const Pose& body(int id) const { return link_[static_cast<std::size_t>(id)]; }

  /// Rotation axis of a degree of freedom, in the world.
  struct Axis {
    Vec3 direction;  ///< unit
    Vec3 point;      ///< on the axis [m]
  };
  /// Axis of a rotational degree of freedom, dof ≥ 3; the first three translate the root.
  [[nodiscard]] const Axis& dof_axis(int dof) const { return axis_[static_cast<std::size_t>(dof)]; }

  /// Inertia of the whole robot about its COM, in the axes of the world [kg·m²].
  [[nodiscard]] Mat3 inertia() const;

  /// Jacobian of the COM, written to `rows` (3 × nv; docs/theory.md §5).
  void com_jacobian(Eigen::Ref<JacobianRows> rows) const;
  /// Jacobian of a point [m, world] fixed to a body (3 × nv).
  void point_jacobian(int body, const Vec3& point, Eigen::Ref<JacobianRows> rows) const;
  /// Jacobian of a body's angular velocity (3 × nv).
  void rotation_jacobian(int body, Eigen::Ref<JacobianRows> rows) const;

  /// Jacobian of a sole: velocity of its centre, then angular velocity (6 × nv).
  void sole_jacobian(Side side, Eigen::Ref<JacobianRows> rows) const;

  /// Inverse dynamics without contact: gravity, inertia and reflected motor inertia, no damping. Sets the
  /// configuration.
  /// @param force receives the generalised forces (nv): force on the root in the world frame 3 [N], moment about its
  /// origin in its own frame 3 [N·m], joint torques [N·m]
  void inverse_dynamics(const VecX& q, const VecX& dq, const VecX& ddq, VecX& force);

  /// Adds to joint torques what an additional acceleration of the whole robot, as if it were one rigid body, asks of
  /// some joints: the root's columns of the inertia matrix.
  /// @param acceleration, angular of the root's origin and of the body, in the world [m/s², rad/s²]
  /// @param joints whose torques are wanted
  /// @param torque of all joints (nv − 6) [N·m]
  void add_rigid_acceleration(const Vec3& acceleration, const Vec3& angular, const std::vector<int>& joints,
                              VecX& torque);

  /// Least distance over the model's self-collision pairs, at most `limit` [m].
  /// @param geoms receives the closest pair, if it is closer than `limit`
  [[nodiscard]] double self_distance(double limit, std::array<int, 2>* geoms = nullptr) const;

 private:
  /// Geometry of a joint, in its link.
  struct Hinge {
    Hinge(const mjModel& m, int j);
    int dof;
    int qpos;             ///< index in q
    double zero;          ///< angle at which the link is as it is mounted [rad]
    Vec3 axis;            ///< unit
    Vec3 anchor;          ///< a point of the axis [m]
    bool off_centre;      ///< whether that is not the link's origin
    int coordinate = -1;  ///< the coordinate axis that `axis` is, or its opposite; -1: neither
  };
  /// Where a link is at zero joint angles, in its parent.
  struct Mount {
    int parent;
    Vec3 position;
    Mat3 rotation;
    bool turned;  ///< whether `rotation` is not the identity
    std::vector<Hinge> hinges;
  };
  /// What accelerates a link and its descendants: force, moment about the root's origin [N, N·m, world].
  struct Carried {
    Vec3 force, moment;
  };

  /// Places a link whose parent has been placed.
  void place(int id, const VecX& q);
  /// Inertia of a link about its COM, in the axes of the world [kg·m²]. On first use after `set`, computes those of
  /// all.
  [[nodiscard]] const Mat3& link_inertia(int id) const;
  /// Computes the mass moments of the subtrees, on first use after `set`.
  void sum_subtrees() const;
  /// Runs MuJoCo's kinematics, on first use after `set`: it takes longer than ours.
  void update_mujoco() const;

  const RobotModel* robot_;
  DataPtr data_;
  VecX q_;
  std::vector<Mount> mounts_;       ///< by link
  std::vector<Mat3> inertia_axes_;  ///< attitude of each link's principal axes of inertia
  std::vector<Pose> link_;
  std::vector<Axis> axis_;                  ///< by degree of freedom
  mutable std::vector<Vec3> subtree_;       ///< mass × COM of each link and its descendants [kg m]
  std::vector<Carried> carried_;            ///< by link
  std::vector<char> carried_by_;            ///< whether a joint that is asked for carries the link; false between calls
  mutable std::vector<Mat3> link_inertia_;  ///< of each link
  mutable bool inertias_valid_ = false;
  mutable bool subtrees_valid_ = false;
  mutable bool mujoco_valid_ = false;
};

/// Sets the root pose in `q` (nq).
void set_root(VecX& q, const Pose& root);

/// q ← q ⊕ dq·dt, for a velocity dq (nv).
void integrate(const RobotModel& robot, VecX& q, const VecX& dq, double dt);

/// dq ← (b ⊖ a)/dt: the velocity (nv) that leads from a to b in `dt`.
void difference(const RobotModel& robot, VecX& dq, double dt, const VecX& a, const VecX& b);

}  // namespace baton
