#include "baton/ik/inverse_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <eiquadprog/eiquadprog-fast.hpp>

namespace baton {
namespace {

constexpr int kMostRows = 30;  ///< soles 2 × 6, COM 3, trunk 3, hands 2 × 6

}  // namespace

struct InverseKinematics::Workspace {
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostRows, kMostRows>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostRows, 1>;

  int rows = 0;
  JacobianRows J;         ///< task rows × nv
  std::vector<int> free;  ///< dofs that the tasks determine; the others follow dq_ref
  MatX J_free;            ///< the columns `free` of J
  Column e;               ///< errors
  Column R;               ///< damping of each row
  VecX dq_ref;            ///< (nv)
  VecX dq;                ///< (nv)
  VecX lower, upper;      ///< bounds of dq of the joints (n)
  Square A;
  Column y;

  /// Quadratic program of a bounded step, in the solver's notation.
  struct Program {
    eiquadprog::solvers::EiquadprogFast qp;
    MatX H, CE, CI;
    VecX g, ce, ci;
  } bounded;
};

InverseKinematics::InverseKinematics(const RobotModel& robot) : InverseKinematics(robot, Parameters{}) {}

InverseKinematics::InverseKinematics(const RobotModel& robot, Parameters parameters)
    : robot_(&robot), parameters_(parameters), kinematics_(robot), w_(std::make_unique<Workspace>()) {
  const int nv = robot.nv();
  const int n = nv - 6;
  w_->J.setZero(kMostRows, nv);
  w_->free.reserve(static_cast<std::size_t>(nv));
  w_->J_free.setZero(kMostRows, nv);
  w_->dq_ref.setZero(nv);
  w_->dq.setZero(nv);
  w_->lower.setZero(n);
  w_->upper.setZero(n);
  Workspace::Program& p = w_->bounded;
  p.H.setZero(nv, nv);
  p.CE.setZero(0, nv);
  p.CI.setZero(2 * n, nv);
  for (int j = 0; j < n; ++j) {
    p.CI(j, 6 + j) = 1.0;
    p.CI(n + j, 6 + j) = -1.0;
  }
  p.g.setZero(nv);
  p.ce.setZero(0);
  p.ci.setZero(2 * n);
  p.qp.reset(nv, 0, 2 * n);
}

InverseKinematics::~InverseKinematics() = default;

void InverseKinematics::measure(const IkTargets& targets, IkResult& result) {
  Workspace& w = *w_;
  const Kinematics& k = kinematics_;
  w.rows = 0;
  w.e.resize(kMostRows);
  w.R.resize(kMostRows);
  // Appends a task's error and returns its norm, or 0 if the target is not finite.
  const auto add = [&](Vec3 error, double damping, bool error_damped) {
    double norm = error.norm();
    if (!std::isfinite(norm)) {
      result.finite_targets = false;
      error.setZero();
      norm = 0.0;
    }
    if (norm > parameters_.largest_step) error *= parameters_.largest_step / norm;
    w.e.segment<3>(w.rows) = error;
    w.R.segment<3>(w.rows).setConstant(damping + (error_damped ? error.squaredNorm() : 0.0));
    w.rows += 3;
    return norm;
  };
  IkResidual& r = result.residual;
  r = {};
  for (const Side side : kSides) {
    const Pose sole = k.sole(side);
    const double hard = parameters_.hard_damping;
    r.sole_position = std::max(r.sole_position, add(targets.sole[side].p - sole.p, hard, false));
    r.sole_rotation = std::max(r.sole_rotation, add(rotation_error(targets.sole[side].R, sole.R), hard, false));
  }
  r.com = add(targets.com - k.com(), parameters_.hard_damping, false);
  r.trunk = add(rotation_error(targets.trunk, k.trunk().R), parameters_.trunk_damping, true);
  for (const Side side : kSides) {
    if (!targets.hand[side]) continue;
    const Pose hand = k.hand(side);
    r.hand = std::max(r.hand, add(targets.hand[side]->p - hand.p, parameters_.hand_damping, true));
    if (robot_->hand_has_attitude(side)) {
      add(rotation_error(targets.hand[side]->R, hand.R), parameters_.hand_damping, true);
    }
  }
  w.e.conservativeResize(w.rows);
  w.R.conservativeResize(w.rows);
}

void InverseKinematics::linearise(const IkTargets& targets) {
  const Kinematics& k = kinematics_;
  int row = 0;
  const auto next = [&] {
    row += 3;
    return w_->J.middleRows(row - 3, 3);
  };
  for (const Side side : kSides) {
    k.point_jacobian(robot_->foot_body(side), k.sole(side).p, next());
    k.rotation_jacobian(robot_->foot_body(side), next());
  }
  k.com_jacobian(next());
  k.rotation_jacobian(robot_->trunk_body(), next());
  for (const Side side : kSides) {
    if (!targets.hand[side]) continue;
    k.point_jacobian(robot_->hand_body(side), k.hand(side).p, next());
    if (robot_->hand_has_attitude(side)) k.rotation_jacobian(robot_->hand_body(side), next());
  }
}

void InverseKinematics::free_step() {
  Workspace& w = *w_;
  const auto J = w.J.topRows(w.rows);
  auto J_free = w.J_free.topLeftCorner(w.rows, static_cast<Eigen::Index>(w.free.size()));
  for (std::size_t k = 0; k < w.free.size(); ++k)
    J_free.col(static_cast<Eigen::Index>(k)) = J.col(w.free[k]);
  w.A.setZero(w.rows, w.rows);
  w.A.selfadjointView<Eigen::Lower>().rankUpdate(J_free);
  w.A.diagonal() += w.R;
  w.y = w.e;
  w.y.noalias() -= J * w.dq_ref;
  w.A.llt().solveInPlace(w.y);
  w.dq = w.dq_ref;
  for (std::size_t k = 0; k < w.free.size(); ++k)
    w.dq[w.free[k]] += J_free.col(static_cast<Eigen::Index>(k)).dot(w.y);
}

void InverseKinematics::bounded_step() {
  Workspace& w = *w_;
  Workspace::Program& p = w.bounded;
  const auto J = w.J.topRows(w.rows);
  const int n = static_cast<int>(w.lower.size());
  constexpr double kFixed = 1e6;  // cost of a joint that follows dq_ref
  VecX cost = VecX::Constant(w.dq.size(), kFixed);
  for (const int i : w.free)
    cost[i] = 1.0;
  const VecX weight = w.R.cwiseInverse();
  p.H.noalias() = J.transpose() * weight.asDiagonal() * J;
  p.H.diagonal() += cost;
  p.g.noalias() = -(J.transpose() * (weight.asDiagonal() * w.e));
  p.g -= cost.cwiseProduct(w.dq_ref);
  p.ci.head(n) = -w.lower;
  p.ci.tail(n) = w.upper;
  VecX x = VecX::Zero(w.dq.size());
  const auto status = p.qp.solve_quadprog(p.H, p.g, p.CE, p.ce, p.CI, p.ci, x);
  if (status == eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL && x.allFinite()) {
    w.dq = x;
  } else {
    // No solution: scale the free step towards 0, where the bounds hold, until it is within them.
    double scale = w.dq.allFinite() ? 1.0 : 0.0;
    for (int j = 0; j < n && scale > 0.0; ++j) {
      const double step = w.dq[6 + j];
      if (step > w.upper[j]) scale = std::min(scale, std::max(0.0, w.upper[j] / step));
      if (step < w.lower[j]) scale = std::min(scale, std::max(0.0, w.lower[j] / step));
    }
    w.dq = scale > 0.0 ? VecX(scale * w.dq) : VecX(VecX::Zero(w.dq.size()));
  }
}

IkResult InverseKinematics::solve(const IkTargets& targets, const VecX& previous, double dt, VecX& q, int iterations) {
  Workspace& w = *w_;
  const auto& joints = robot_->joints();
  const int n = static_cast<int>(joints.size());
  BySide<bool> follow{!targets.hand.left, !targets.hand.right};
  const auto is_in = [](const std::vector<int>& chain, int j) { return std::ranges::find(chain, j) != chain.end(); };
  w.free.clear();
  for (int i = 0; i < robot_->nv(); ++i) {
    const bool follows = is_in(robot_->idle(), i - 6) || (follow.left && is_in(robot_->arm(Side::left), i - 6)) ||
                         (follow.right && is_in(robot_->arm(Side::right), i - 6));
    if (!follows) w.free.push_back(i);
  }
  const auto lowest = [&](int j) {
    const auto& joint = joints[static_cast<std::size_t>(j)];
    return std::max(joint.position.lo, previous[7 + j] - joint.speed * dt);
  };
  const auto highest = [&](int j) {
    const auto& joint = joints[static_cast<std::size_t>(j)];
    return std::min(joint.position.hi, previous[7 + j] + joint.speed * dt);
  };
  for (int j = 0; j < n; ++j)
    q[7 + j] = std::clamp(q[7 + j], lowest(j), std::max(lowest(j), highest(j)));

  IkResult result;
  kinematics_.set(q);
  measure(targets, result);
  for (; result.iterations < iterations; ++result.iterations) {
    w.dq_ref.setZero();
    for (int j = 0; j < n; ++j) {
      w.lower[j] = lowest(j) - q[7 + j];
      w.upper[j] = std::max(w.lower[j], highest(j) - q[7 + j]);
    }
    double arm_error = 0.0;
    for (const Side side : kSides) {
      if (!follow[side]) continue;
      for (const int j : robot_->arm(side)) {
        const double wish = targets.arms[j] - q[7 + j];
        if (!std::isfinite(wish)) {
          result.finite_targets = false;
          continue;
        }
        w.dq_ref[6 + j] = std::clamp(wish, w.lower[j], w.upper[j]);
        arm_error = std::max(arm_error, std::abs(w.dq_ref[6 + j]));
      }
    }
    for (const int j : robot_->idle()) {
      w.dq_ref[6 + j] = std::clamp(joints[static_cast<std::size_t>(j)].home - q[7 + j], w.lower[j], w.upper[j]);
      arm_error = std::max(arm_error, std::abs(w.dq_ref[6 + j]));
    }
    const IkResidual& r = result.residual;
    if (std::max({r.sole_position, r.sole_rotation, r.com, arm_error}) < parameters_.tolerance &&
        std::max(r.trunk, r.hand) < 10.0 * parameters_.tolerance) {
      break;
    }
    linearise(targets);
    free_step();
    result.bound_joint = -1;
    for (int j = 0; j < n && result.bound_joint < 0; ++j) {
      if (!(w.dq[6 + j] <= w.upper[j] + 1e-12 && w.dq[6 + j] >= w.lower[j] - 1e-12)) result.bound_joint = j;
    }
    if (result.bound_joint >= 0) bounded_step();
    integrate(*robot_, q, w.dq, 1.0);
    for (int j = 0; j < n; ++j)
      q[7 + j] = std::clamp(q[7 + j], lowest(j), std::max(lowest(j), highest(j)));
    kinematics_.set(q);
    measure(targets, result);
  }
  return result;
}

}  // namespace baton
