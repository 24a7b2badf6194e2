#include "baton/balance/wrench_distribution.hpp"

#include <algorithm>
#include <cmath>
#include <eiquadprog/eiquadprog-fast.hpp>
#include <limits>

namespace baton {
namespace {

constexpr double kMomentCost = 1e3;  ///< cost of a squared change of the total moment, against that of the shift
constexpr double kForceCost = 1e5;   ///< the same of the total force, times the COM height
constexpr double kSlackCost = 1e9;   ///< the same of the largest violation
constexpr double kInset = 0.5;       ///< share of `zmp_feedback`: an inset hull is not the hull of inset soles

/// Contact-wrench cone for (fx, fy, fz, mx, my, mz) about the sole's centre. Friction-force rows are multiplied by
/// `lever` [m].
WrenchDistribution::ConeRows limits_of(const ConvexPolygon& outline, double friction, double lever) {
  const std::vector<Vec2>& vertices = outline.vertices();
  const auto n = static_cast<Eigen::Index>(vertices.size());
  WrenchDistribution::ConeRows limits = WrenchDistribution::ConeRows::Zero(n + 8, 6);
  double radius = std::numeric_limits<double>::infinity();
  Range length{0.0, 0.0};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec2& from = vertices[static_cast<std::size_t>(i)];
    length = {std::min(length.lo, from.x()), std::max(length.hi, from.x())};
    const Vec2 along = (vertices[static_cast<std::size_t>((i + 1) % n)] - from).normalized();
    const Vec2 inward(-along.y(), along.x());
    // The centre of pressure (−my, mx)/fz is on the inner side of each edge.
    limits.row(i) << 0.0, 0.0, -inward.dot(from), inward.y(), -inward.x(), 0.0;
    radius = std::min(radius, -inward.dot(from));
  }
  const double pyramid = friction / std::sqrt(2.0);  // inscribed in the cone
  // Twist of the largest inscribed disc, evenly loaded; of a long sole, more, by a line from heel to toe that is evenly
  // loaded. The nearer the centre of pressure is to its ends, the less is added.
  const double twist = 2.0 / 3.0 * radius * friction;
  const double more = std::max(0.0, 0.5 * friction * std::min(-length.lo, length.hi) - twist);
  const auto towards = [more](double end) { return more > 0.0 ? more / end : 0.0; };
  for (Eigen::Index sign = 0; sign < 2; ++sign) {
    const double s = sign == 0 ? 1.0 : -1.0;
    limits.row(n + sign) << s * lever, 0.0, pyramid * lever, 0.0, 0.0, 0.0;
    limits.row(n + 2 + sign) << 0.0, s * lever, pyramid * lever, 0.0, 0.0, 0.0;
    limits.row(n + 4 + sign) << 0.0, 0.0, twist + more, 0.0, towards(length.hi), s;
    limits.row(n + 6 + sign) << 0.0, 0.0, twist + more, 0.0, towards(length.lo), s;
  }
  return limits;
}

}  // namespace

/// The smallest x with CI x + ci ≥ 0.
struct WrenchDistribution::Program {
  /// Unknowns: force and moment shifted from the right sole to the left one (6), changes of the total moment (3)
  /// and horizontal force (2), the largest violation (1); each times the root of its cost.
  static constexpr Eigen::Index kUnknowns = 12;

  explicit Program(Eigen::Index rows)
      : H(Eigen::MatrixXd::Identity(kUnknowns, kUnknowns)),
        g(VecX::Zero(kUnknowns)),
        CE(0, kUnknowns),
        CI(Eigen::MatrixXd::Zero(rows, kUnknowns)),
        ci(VecX::Ones(rows)),
        x(VecX::Zero(kUnknowns)) {
    qp.reset(kUnknowns, 0, static_cast<std::size_t>(rows));
  }

  eiquadprog::solvers::EiquadprogFast qp;
  Eigen::MatrixXd H;
  VecX g;
  Eigen::MatrixXd CE;
  VecX ce;
  Eigen::MatrixXd CI;
  VecX ci;
  VecX x;
};

WrenchDistribution::WrenchDistribution(const RobotModel& robot)
    : robot_(&robot), lever_(0.5 * robot.profile().stance.width) {
  const Profile::Margin& margin = robot.profile().margin;
  Eigen::Index rows = 0;
  for (const Side side : kSides) {
    limits_[side] = limits_of(robot.sole(side).inset(kInset * margin.zmp_feedback), margin.friction, lever_);
    rows += limits_[side].rows() + 2 * static_cast<Eigen::Index>(robot.leg(side).size());
  }
  program_ = std::make_unique<Program>(rows);
}

WrenchDistribution::~WrenchDistribution() = default;
WrenchDistribution::WrenchDistribution(WrenchDistribution&&) noexcept = default;
WrenchDistribution& WrenchDistribution::operator=(WrenchDistribution&&) noexcept = default;

BySide<Wrench> WrenchDistribution::share(const Kinematics& kinematics, const BySide<Pose>& sole,
                                         const BySide<bool>& contact, const Wrench& total, const VecX& unloaded) {
  BySide<Wrench> shared = share_wrench(*robot_, sole, contact, total);
  if (compare(kinematics, sole, contact, shared, unloaded) >= 0.0) return shared;

  const bool both = contact.left && contact.right;
  const double height = robot_->profile().stance.com_height;
  const double moment_unit = 1.0 / std::sqrt(kMomentCost);
  const double force_unit = 1.0 / (std::sqrt(kForceCost) * height);
  BySide<double> load{contact.left ? 1.0 : 0.0, contact.right ? 1.0 : 0.0};
  if (both) load.left = std::clamp(shared.left.force.z() / total.force.z(), 0.0, 1.0);
  if (both) load.right = 1.0 - load.left;
  const Vec3 origin = both ? Vec3(0.5 * (sole.left.p + sole.right.p)) : contact.left ? sole.left.p : sole.right.p;
  // A force at the COM, given by the soles by their loads: with this arm about the origin.
  const Vec3 above = kinematics.com() - load.left * sole.left.p - load.right * sole.right.p;
  BySide<Vec3> arm;
  for (const Side side : kSides)
    arm[side] = sole[side].p - origin + above;

  // A row for a limit that a sole's force and moment about the origin change by `force` and `moment`.
  Program& p = *program_;
  p.CI.setZero();
  Eigen::Index row = 0;
  const auto add = [&](Side side, const Vec3& force, const Vec3& moment) {
    auto a = p.CI.row(row++);
    if (both) {
      a.segment<3>(0) = sign_of(side) / lever_ * force.transpose();
      a.segment<3>(3) = sign_of(side) * moment.transpose();
    }
    a.segment<3>(6) = load[side] * moment_unit * moment.transpose();
    a.segment<2>(9) = load[side] * force_unit * (force + moment.cross(arm[side])).head<2>().transpose();
    a[11] = 1.0 / std::sqrt(kSlackCost);
  };
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    const Mat3& R = sole[side].R;
    for (Eigen::Index i = 0; i < limits_[side].rows(); ++i) {
      const Vec3 moment = R * limits_[side].row(i).tail<3>().transpose();
      const Vec3 force = R * limits_[side].row(i).head<3>().transpose();
      add(side, force - moment.cross(sole[side].p - origin), moment);
    }
    for (const int j : robot_->leg(side)) {
      const Kinematics::Axis& axis = kinematics.dof_axis(6 + j);
      const Vec3 force = axis.direction.cross(axis.point - origin);
      add(side, -force, axis.direction);
      add(side, force, -axis.direction);
    }
  }

  const auto status = p.qp.solve_quadprog(p.H, p.g, p.CE, p.ce, p.CI, p.ci, p.x);
  if (status != eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL || !p.x.allFinite()) return shared;
  const VecX& x = p.x;
  const Vec3 shift_force = x.segment<3>(0) / lever_;
  const Vec3 shift_moment = x.segment<3>(3) + origin.cross(shift_force);
  const Vec3 moment = moment_unit * x.segment<3>(6);
  const Vec3 force(force_unit * x[9], force_unit * x[10], 0.0);
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    if (both) {
      shared[side].force += sign_of(side) * shift_force;
      shared[side].moment += sign_of(side) * shift_moment;
    }
    shared[side].force += load[side] * force;
    shared[side].moment += load[side] * (moment + (arm[side] + origin).cross(force));
  }
  return shared;
}

double WrenchDistribution::compare(const Kinematics& kinematics, const BySide<Pose>& sole, const BySide<bool>& contact,
                                   const BySide<Wrench>& shared, const VecX& unloaded) {
  VecX& left = program_->ci;
  Eigen::Index count = 0;
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    const Mat3 to_sole = sole[side].R.transpose();
    Vec6 own;
    own << to_sole * shared[side].force, to_sole * shared[side].moment_about(sole[side].p);
    const Eigen::Index rows = limits_[side].rows();
    left.segment(count, rows).noalias() = limits_[side] * own;
    count += rows;
    for (const int j : robot_->leg(side)) {
      const Kinematics::Axis& axis = kinematics.dof_axis(6 + j);
      const double torque = unloaded[j] - axis.direction.dot(shared[side].moment_about(axis.point));
      const double stall = robot_->joints()[static_cast<std::size_t>(j)].motor.stall;
      left[count++] = stall - torque;
      left[count++] = stall + torque;
    }
  }
  left.tail(left.size() - count).setOnes();  // rows of zeros for a sole without contact
  return left.minCoeff();
}

}  // namespace baton
