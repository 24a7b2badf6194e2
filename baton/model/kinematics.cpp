#include "baton/model/kinematics.hpp"

#include <cmath>

namespace baton {
namespace {

Eigen::Map<const Vec3> vec3(const mjtNum* values) {
  return Eigen::Map<const Vec3>(values);
}

}  // namespace

Kinematics::Kinematics(const RobotModel& robot) : robot_(&robot), data_(mj_makeData(&robot.mj())) {}

void Kinematics::set(const VecX& q) {
  mju_copy(data_->qpos, q.data(), robot_->nq());
  mj_kinematics(&robot_->mj(), data_.get());
  prepared_ = false;
}

void Kinematics::prepare() const {
  if (!prepared_) mj_comPos(&robot_->mj(), data_.get());
  prepared_ = true;
}

Vec3 Kinematics::com() const {
  const mjModel& m = robot_->mj();
  Vec3 moment = Vec3::Zero();
  for (int b = 1; b < m.nbody; ++b)
    moment += m.body_mass[b] * vec3(data_->xipos + 3 * b);
  return moment / robot_->mass();
}

Pose Kinematics::body(int id) const {
  return {vec3(data_->xpos + 3 * id),
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->xmat + 9 * id)};
}

Kinematics::Axis Kinematics::dof_axis(int dof) const {
  const int joint = robot_->mj().dof_jntid[dof];
  return {vec3(data_->xaxis + 3 * joint), vec3(data_->xanchor + 3 * joint)};
}

void Kinematics::com_jacobian(Eigen::Ref<JacobianRows> rows) const {
  prepare();
  const mjModel& m = robot_->mj();
  const Vec3 origin = vec3(data_->subtree_com + 3);
  for (int i = 0; i < m.nv; ++i) {
    const int body = m.dof_bodyid[i];
    const mjtNum* axis = data_->cdof + 6 * i;  // rotation, then translation, about the robot's COM
    rows.col(i) = (vec3(axis + 3) + vec3(axis).cross(vec3(data_->subtree_com + 3 * body) - origin)) *
                  (m.body_subtreemass[body] / robot_->mass());
  }
}

void Kinematics::point_jacobian(int body, const Vec3& point, Eigen::Ref<JacobianRows> rows) const {
  prepare();
  rows.setZero();
  const Vec3 lever = point - vec3(data_->subtree_com + 3);
  for (const int i : robot_->dofs_to(body)) {
    const mjtNum* axis = data_->cdof + 6 * i;
    rows.col(i) = vec3(axis + 3) + vec3(axis).cross(lever);
  }
}

void Kinematics::rotation_jacobian(int body, Eigen::Ref<JacobianRows> rows) const {
  prepare();
  rows.setZero();
  for (const int i : robot_->dofs_to(body))
    rows.col(i) = vec3(data_->cdof + 6 * i);
}

void Kinematics::sole_jacobian(Side side, Eigen::Ref<JacobianRows> rows) const {
  const int foot = robot_->foot_body(side);
  point_jacobian(foot, sole(side).p, rows.topRows(3));
  rotation_jacobian(foot, rows.bottomRows(3));
}

void Kinematics::inverse_dynamics(const VecX& q, const VecX& dq, const VecX& ddq, VecX& force) {
  const mjModel& m = robot_->mj();
  set(q);
  prepare();
  mju_copy(data_->qvel, dq.data(), m.nv);
  mju_copy(data_->qacc, ddq.data(), m.nv);
  mj_comVel(&m, data_.get());
  mj_rne(&m, data_.get(), 1, force.data());
  for (int i = 0; i < m.nv; ++i)
    force[i] += m.dof_armature[i] * ddq[i];
}

double Kinematics::self_distance(double limit, std::array<int, 2>* geoms) const {
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
