#include "baton/verify/vertex_forces.hpp"

#include <cmath>
#include <eiquadprog/eiquadprog-fast.hpp>
#include <limits>

namespace baton {
namespace {

constexpr double kRegularisation = 1e-8;  ///< ε, for forces in units of the weight

}  // namespace

struct VertexForces::Workspace {
  eiquadprog::solvers::EiquadprogFast qp;
  Eigen::Matrix<double, 6, Eigen::Dynamic> G;
  MatX H, CE, CI;
  VecX g, ce, ci, f;
};

VertexForces::VertexForces(const RobotModel& robot, const Limits& limits)
    : robot_(&robot), w_(std::make_unique<Workspace>()) {
  set(limits);
}

VertexForces::~VertexForces() = default;

void VertexForces::set(const Limits& limits) {
  for (const Side side : kSides)
    vertices_[side] = robot_->sole(side).inset(limits.zmp_verify).vertices();
  friction_ = limits.friction;
}

double VertexForces::missing(const BySide<Pose>& sole, const BySide<bool>& contact, const Wrench& total,
                             const Vec3& com) {
  Workspace& w = *w_;
  Eigen::Index n = 0;
  for (const Side side : kSides)
    n += contact[side] ? static_cast<Eigen::Index>(vertices_[side].size()) : 0;
  if (n == 0) return std::numeric_limits<double>::infinity();
  const double weight = robot_->mass() * kGravity;
  const double length = robot_->profile().stance.com_height;
  // The friction pyramid inscribed in the cone.
  const double mu = friction_ / std::sqrt(2.0);
  w.G.setZero(6, 3 * n);
  Eigen::Matrix<double, 6, 6> gram = kRegularisation * Eigen::Matrix<double, 6, 6>::Identity();
  Eigen::Index i = 0;
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    for (const Vec2& vertex : vertices_[side]) {
      const Vec3 arm = (sole[side] * Vec3(vertex.x(), vertex.y(), 0) - com) / length;
      const Mat3& R = sole[side].R;
      w.G.block<3, 3>(0, 3 * i) = R;
      for (int axis = 0; axis < 3; ++axis) {
        w.G.block<3, 1>(3, 3 * i + axis) = arm.cross(R.col(axis));
        gram.noalias() += w.G.col(3 * i + axis) * w.G.col(3 * i + axis).transpose();
      }
      ++i;
    }
  }
  Vec6 wanted;
  wanted << total.force / weight, total.moment_about(com) / (weight * length);
  if (!wanted.allFinite()) return std::numeric_limits<double>::infinity();
  // The unconstrained minimiser is the answer if it lies in the pyramids.
  w.f.noalias() = w.G.transpose() * gram.ldlt().solve(wanted);
  bool inside = true;
  for (i = 0; i < n && inside; ++i)
    inside = w.f.segment<2>(3 * i).cwiseAbs().maxCoeff() <= mu * w.f[3 * i + 2];
  if (inside) return (w.G * w.f - wanted).norm();
  w.CI.setZero(5 * n, 3 * n);
  for (i = 0; i < n; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      w.CI(5 * i + 2 * axis, 3 * i + axis) = 1.0;
      w.CI(5 * i + 2 * axis + 1, 3 * i + axis) = -1.0;
      w.CI(5 * i + 2 * axis, 3 * i + 2) = mu;
      w.CI(5 * i + 2 * axis + 1, 3 * i + 2) = mu;
    }
    w.CI(5 * i + 4, 3 * i + 2) = 1.0;
  }
  w.H.noalias() = w.G.transpose() * w.G;
  w.H.diagonal().array() += kRegularisation;
  w.g.noalias() = -(w.G.transpose() * wanted);
  w.CE.setZero(0, 3 * n);
  w.ce.setZero(0);
  w.ci.setZero(5 * n);
  w.f.setZero(3 * n);
  w.qp.reset(static_cast<std::size_t>(3 * n), 0, static_cast<std::size_t>(5 * n));
  const auto status = w.qp.solve_quadprog(w.H, w.g, w.CE, w.ce, w.CI, w.ci, w.f);
  if (status != eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL || !w.f.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  return (w.G * w.f - wanted).norm();
}

}  // namespace baton
