#include "baton/model/kinematics.hpp"

#include <utility>

namespace baton {
namespace {

Eigen::Map<const Vec3> vec3(const mjtNum* values) {
  return Eigen::Map<const Vec3>(values);
}

Mat3 matrix(const mjtNum* quat) {
  return Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix();
}

}  // namespace

Kinematics::Hinge::Hinge(const mjModel& m, int j)
    : dof(m.jnt_dofadr[j]),
      qpos(m.jnt_qposadr[j]),
      zero(m.qpos0[m.jnt_qposadr[j]]),
      axis(vec3(m.jnt_axis + 3 * j)),
      anchor(vec3(m.jnt_pos + 3 * j)),
      off_centre(!anchor.isZero(0.0)) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) == 1.0) coordinate = k;
  }
}

Kinematics::Kinematics(const RobotModel& robot) : robot_(&robot), data_(mj_makeData(&robot.mj())), q_(robot.nq()) {
  const mjModel& m = robot.mj();
  for (int b = 0; b < m.nbody; ++b) {
    const Mat3 R = matrix(m.body_quat + 4 * b);
    inertia_axes_.push_back(matrix(m.body_iquat + 4 * b));
    Mount mount{m.body_parentid[b], vec3(m.body_pos + 3 * b), R, !R.isIdentity(0.0), {}};
    if (b > 1) {
      for (int j = m.body_jntadr[b]; j < m.body_jntadr[b] + m.body_jntnum[b]; ++j)
        mount.hinges.emplace_back(m, j);
    }
    mounts_.push_back(std::move(mount));
  }
  link_.resize(mounts_.size());
  subtree_.resize(mounts_.size());
  carried_.resize(mounts_.size());
  carried_by_.resize(mounts_.size());
  link_inertia_.resize(mounts_.size());
  axis_.resize(static_cast<std::size_t>(m.nv));
}

void Kinematics::set(const VecX& q) {
  const mjModel& m = robot_->mj();
  q_ = q;
  link_[1] = {q.head<3>(), Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized().toRotationMatrix()};
  for (int k = 0; k < 3; ++k)
    axis_[static_cast<std::size_t>(3 + k)] = {link_[1].R.col(k), link_[1].p};
  for (int b = 2; b < m.nbody; ++b)
    place(b, q);
  subtrees_valid_ = mujoco_valid_ = inertias_valid_ = false;
}

void Kinematics::set_moved(const Kinematics& other, const Pose& by, const VecX& q) {
  q_ = q;
  for (std::size_t i = 1; i < link_.size(); ++i)
    link_[i] = by * other.link_[i];
  for (std::size_t i = 3; i < axis_.size(); ++i)
    axis_[i] = {by.R * other.axis_[i].direction, by * other.axis_[i].point};
  subtrees_valid_ = mujoco_valid_ = inertias_valid_ = false;
}

void Kinematics::set_links(const VecX& q, const std::vector<int>& links) {
  q_ = q;
  for (const int b : links)
    place(b, q);
  subtrees_valid_ = mujoco_valid_ = inertias_valid_ = false;
}

void Kinematics::place(int id, const VecX& q) {
  const auto i = static_cast<std::size_t>(id);
  const Mount& mount = mounts_[i];
  const Pose& parent = link_[static_cast<std::size_t>(mount.parent)];
  Mat3& R = link_[i].R;
  Vec3 p = parent.p + parent.R.lazyProduct(mount.position);
  if (mount.turned)
    R = parent.R.lazyProduct(mount.rotation);
  else
    R = parent.R;
  for (const Hinge& hinge : mount.hinges) {
    const double angle = q[hinge.qpos] - hinge.zero;
    const double c = std::cos(angle);  // here, before anything is written, one call computes both
    const double s = std::sin(angle);
    Axis& axis = axis_[static_cast<std::size_t>(hinge.dof)];
    if (hinge.off_centre) p += R.lazyProduct(hinge.anchor);
    axis.point = p;
    if (hinge.coordinate < 0) {
      axis.direction = R.lazyProduct(hinge.axis);
      R *= Eigen::AngleAxisd(angle, hinge.axis).toRotationMatrix();
    } else {
      const double sign = hinge.axis[hinge.coordinate];
      axis.direction = sign * R.col(hinge.coordinate);
      const int next_axis = (hinge.coordinate + 1) % 3;
      const int last_axis = (hinge.coordinate + 2) % 3;
      const Vec3 next = R.col(next_axis);
      const Vec3 last = R.col(last_axis);
      R.col(next_axis) = c * next + sign * s * last;
      R.col(last_axis) = c * last - sign * s * next;
    }
    if (hinge.off_centre) p -= R.lazyProduct(hinge.anchor);
  }
  link_[i].p = p;
}

void Kinematics::sum_subtrees() const {
  if (std::exchange(subtrees_valid_, true)) return;
  const mjModel& m = robot_->mj();
  for (int b = 1; b < m.nbody; ++b) {
    const auto i = static_cast<std::size_t>(b);
    subtree_[i] = m.body_mass[b] * (link_[i] * vec3(m.body_ipos + 3 * b));
  }
  for (int b = m.nbody - 1; b > 1; --b)
    subtree_[static_cast<std::size_t>(m.body_parentid[b])] += subtree_[static_cast<std::size_t>(b)];
}

void Kinematics::update_mujoco() const {
  if (std::exchange(mujoco_valid_, true)) return;
  mju_copy(data_->qpos, q_.data(), robot_->nq());
  mj_kinematics(&robot_->mj(), data_.get());
}

Vec3 Kinematics::com() const {
  sum_subtrees();
  return subtree_[1] / robot_->mass();
}

Mat3 Kinematics::inertia() const {
  const mjModel& m = robot_->mj();
  const Vec3 centre = com();
  Mat3 sum = Mat3::Zero();
  for (int b = 1; b < m.nbody; ++b) {
    const auto i = static_cast<std::size_t>(b);
    const Vec3 at = link_[i] * vec3(m.body_ipos + 3 * b) - centre;
    sum += link_inertia(b);
    sum += m.body_mass[b] * (at.squaredNorm() * Mat3::Identity() - at * at.transpose());
  }
  return sum;
}

const Mat3& Kinematics::link_inertia(int id) const {
  if (!std::exchange(inertias_valid_, true)) {
    for (int b = 1; b < robot_->mj().nbody; ++b) {
      const auto i = static_cast<std::size_t>(b);
      const Mat3 axes = link_[i].R.lazyProduct(inertia_axes_[i]);
      const Mat3 scaled = axes * vec3(robot_->mj().body_inertia + 3 * b).asDiagonal();
      link_inertia_[i] = scaled.lazyProduct(axes.transpose());
    }
  }
  return link_inertia_[static_cast<std::size_t>(id)];
}

void Kinematics::add_rigid_acceleration(const Vec3& acceleration, const Vec3& angular, const std::vector<int>& joints,
                                        VecX& torque) {
  const mjModel& m = robot_->mj();
  const Vec3 root = body(1).p;
  for (const int j : joints)
    carried_by_[static_cast<std::size_t>(m.dof_bodyid[6 + j])] = true;
  for (int b = 2; b < m.nbody; ++b) {
    const auto i = static_cast<std::size_t>(b);
    carried_by_[i] = carried_by_[i] || carried_by_[static_cast<std::size_t>(m.body_parentid[b])];
    if (!carried_by_[i]) continue;
    const Vec3 at = body(b) * vec3(m.body_ipos + 3 * b) - root;
    const Vec3 force = m.body_mass[b] * (acceleration + angular.cross(at));
    carried_[i] = {force, link_inertia(b) * angular + at.cross(force)};
  }
  for (int b = m.nbody - 1; b > 1; --b) {
    const auto parent = static_cast<std::size_t>(m.body_parentid[b]);
    const bool carried = std::exchange(carried_by_[static_cast<std::size_t>(b)], false);
    if (!carried || !carried_by_[parent]) continue;
    carried_[parent].force += carried_[static_cast<std::size_t>(b)].force;
    carried_[parent].moment += carried_[static_cast<std::size_t>(b)].moment;
  }
  for (const int j : joints) {
    const Axis& axis = dof_axis(6 + j);
    const Carried& link = carried_[static_cast<std::size_t>(m.dof_bodyid[6 + j])];
    torque[j] += axis.direction.dot(link.moment - (axis.point - root).cross(link.force));
  }
}

void Kinematics::com_jacobian(Eigen::Ref<JacobianRows> rows) const {
  sum_subtrees();
  const mjModel& m = robot_->mj();
  rows.leftCols<3>().setIdentity();
  for (int i = 3; i < m.nv; ++i) {
    const int body = m.dof_bodyid[i];
    const Axis& axis = dof_axis(i);
    rows.col(i) =
        axis.direction.cross(subtree_[static_cast<std::size_t>(body)] - m.body_subtreemass[body] * axis.point) /
        robot_->mass();
  }
}

void Kinematics::point_jacobian(int body, const Vec3& point, Eigen::Ref<JacobianRows> rows) const {
  rows.setZero();
  rows.leftCols<3>().setIdentity();
  for (const int i : robot_->dofs_to(body)) {
    if (i >= 3) rows.col(i) = dof_axis(i).direction.cross(point - dof_axis(i).point);
  }
}

void Kinematics::rotation_jacobian(int body, Eigen::Ref<JacobianRows> rows) const {
  rows.setZero();
  for (const int i : robot_->dofs_to(body)) {
    if (i >= 3) rows.col(i) = dof_axis(i).direction;
  }
}

void Kinematics::sole_jacobian(Side side, Eigen::Ref<JacobianRows> rows) const {
  const int foot = robot_->foot_body(side);
  point_jacobian(foot, sole(side).p, rows.topRows(3));
  rotation_jacobian(foot, rows.bottomRows(3));
}

void Kinematics::inverse_dynamics(const VecX& q, const VecX& dq, const VecX& ddq, VecX& force) {
  const mjModel& m = robot_->mj();
  set(q);
  // The results of mj_kinematics that mj_comPos and mj_rne read.
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  for (int b = 1; b < m.nbody; ++b) {
    const Pose& link = body(b);
    Eigen::Map<Vec3>(data_->xpos + 3 * b) = link.p;
    Eigen::Map<Rows>(data_->xmat + 9 * b) = link.R;
    Eigen::Map<Vec3>(data_->xipos + 3 * b) = link * vec3(m.body_ipos + 3 * b);
    Eigen::Map<Rows>(data_->ximat + 9 * b) = link.R * inertia_axes_[static_cast<std::size_t>(b)];
  }
  for (int j = 1; j < m.njnt; ++j) {
    const Axis& axis = dof_axis(m.jnt_dofadr[j]);
    Eigen::Map<Vec3>(data_->xaxis + 3 * j) = axis.direction;
    Eigen::Map<Vec3>(data_->xanchor + 3 * j) = axis.point;
  }
  Eigen::Map<Vec3>(data_->xanchor) = body(1).p;
  mj_comPos(&m, data_.get());
  mju_copy(data_->qvel, dq.data(), m.nv);
  mju_copy(data_->qacc, ddq.data(), m.nv);
  mj_comVel(&m, data_.get());
  mj_rne(&m, data_.get(), 1, force.data());
  for (int i = 0; i < m.nv; ++i)
    force[i] += m.dof_armature[i] * ddq[i];
}

double Kinematics::self_distance(double limit, std::array<int, 2>* geoms) const {
  update_mujoco();
  const mjModel& m = robot_->mj();
  double least = limit;
  for (int k = 0; k < m.npair; ++k) {
    const int a = m.pair_geom1[k];
    const int b = m.pair_geom2[k];
    const double centres = (vec3(data_->geom_xpos + 3 * a) - vec3(data_->geom_xpos + 3 * b)).norm();
    if (centres - m.geom_rbound[a] - m.geom_rbound[b] >= least) continue;
    const double distance = mj_geomDistance(&m, data_.get(), a, b, least, nullptr);
    if (distance < least) {
      least = distance;
      if (geoms != nullptr) *geoms = {a, b};
    }
  }
  return least;
}

void set_root(VecX& q, const Pose& root) {
  const Eigen::Quaterniond attitude(root.R);
  q.head<3>() = root.p;
  q.segment<4>(3) << attitude.w(), attitude.x(), attitude.y(), attitude.z();
}

void integrate(const RobotModel& robot, VecX& q, const VecX& dq, double dt) {
  mj_integratePos(&robot.mj(), q.data(), dq.data(), dt);
}

void difference(const RobotModel& robot, VecX& dq, double dt, const VecX& a, const VecX& b) {
  mj_differentiatePos(&robot.mj(), dq.data(), dt, a.data(), b.data());
}

}  // namespace baton
