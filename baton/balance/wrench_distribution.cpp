#include "baton/balance/wrench_distribution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace baton {
namespace {

constexpr double kSlackCost = 1e3;   ///< cost of a squared violation, against that of the squared shift
constexpr double kInset = 0.5;       ///< share of `zmp_feedback`: an inset hull is not the hull of inset soles
constexpr int kMaxSweeps = 200;      ///< over all limits
constexpr double kTolerance = 1e-7;  ///< change in a sweep below which it ends [weight × lever]

/// Contact-wrench cone for (fx, fy, fz, mx, my, mz) about the sole's centre. Friction-force rows are multiplied by
/// `lever` [m].
WrenchDistribution::ConeRows limits_of(const ConvexPolygon& outline, double friction, double lever) {
  const std::vector<Vec2>& vertices = outline.vertices();
  const auto n = static_cast<Eigen::Index>(vertices.size());
  WrenchDistribution::ConeRows limits = WrenchDistribution::ConeRows::Zero(n + 6, 6);
  double radius = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec2& from = vertices[static_cast<std::size_t>(i)];
    const Vec2 along = (vertices[static_cast<std::size_t>((i + 1) % n)] - from).normalized();
    const Vec2 inward(-along.y(), along.x());
    // The centre of pressure (−my, mx)/fz is on the inner side of each edge.
    limits.row(i) << 0.0, 0.0, -inward.dot(from), inward.y(), -inward.x(), 0.0;
    radius = std::min(radius, -inward.dot(from));
  }
  const double pyramid = friction / std::sqrt(2.0);    // inscribed in the cone
  const double twist = 2.0 / 3.0 * radius * friction;  // of the largest inscribed disc, evenly loaded
  for (Eigen::Index sign = 0; sign < 2; ++sign) {
    const double s = sign == 0 ? 1.0 : -1.0;
    limits.row(n + sign) << s * lever, 0.0, pyramid * lever, 0.0, 0.0, 0.0;
    limits.row(n + 2 + sign) << 0.0, s * lever, pyramid * lever, 0.0, 0.0, 0.0;
    limits.row(n + 4 + sign) << 0.0, 0.0, twist, 0.0, 0.0, s;
  }
  return limits;
}

}  // namespace

WrenchDistribution::WrenchDistribution(const RobotModel& robot)
    : robot_(&robot), lever_(0.5 * robot.profile().stance.width) {
  const Profile::Margin& margin = robot.profile().margin;
  for (const Side side : kSides)
    limits_[side] = limits_of(robot.sole(side).inset(kInset * margin.zmp_feedback), margin.friction, lever_);
  const Eigen::Index rows = limits_.left.rows() + limits_.right.rows();
  A_.setZero(rows, 6);
  b_.setZero(rows);
  multiplier_.setZero(rows);
}

BySide<Wrench> WrenchDistribution::share(const BySide<Pose>& sole, const BySide<bool>& contact, const Wrench& total) {
  BySide<Wrench> shared = share_wrench(*robot_, sole, contact, total);
  if (!contact.left || !contact.right) return shared;
  // The unknown is the wrench shifted from the right sole to the left one: force times lever, and moment about the
  // middle.
  const Vec3 middle = 0.5 * (sole.left.p + sole.right.p);
  Eigen::Index row = 0;
  for (const Side side : kSides) {
    const Mat3 to_sole = sole[side].R.transpose();
    Vec6 own;
    own << to_sole * shared[side].force, to_sole * shared[side].moment_about(sole[side].p);
    Eigen::Matrix<double, 6, 6> given = Eigen::Matrix<double, 6, 6>::Zero();
    given.topLeftCorner<3, 3>() = to_sole / lever_;
    given.bottomLeftCorner<3, 3>() = to_sole * skew(middle - sole[side].p) / lever_;
    given.bottomRightCorner<3, 3>() = to_sole;
    for (Eigen::Index i = 0; i < limits_[side].rows(); ++i, ++row) {
      A_.row(row).noalias() = sign_of(side) * limits_[side].row(i) * given;
      b_[row] = limits_[side].row(i).dot(own);
    }
  }
  const Vec6 shift = smallest_shift();
  const Vec3 force = shift.head<3>() / lever_;
  const Vec3 moment = shift.tail<3>() + middle.cross(force);
  for (const Side side : kSides) {
    shared[side].force += sign_of(side) * force;
    shared[side].moment += sign_of(side) * moment;
  }
  return shared;
}

Vec6 WrenchDistribution::smallest_shift() {
  // Coordinate ascent on the dual of min |x|² + kSlackCost |s|² subject to A x + b + s ≥ 0; multipliers are ≥ 0.
  Vec6 x = Vec6::Zero();
  if (b_.minCoeff() >= 0.0) return x;
  multiplier_.setZero();
  const double exact = kTolerance * robot_->mass() * kGravity * lever_;
  double change = 2.0 * exact;
  for (int sweep = 0; sweep < kMaxSweeps && change > exact; ++sweep) {
    change = 0.0;
    for (Eigen::Index i = 0; i < b_.size(); ++i) {
      const Vec6 a = A_.row(i).transpose();
      const double lacks = -(a.dot(x) + b_[i] + multiplier_[i] / kSlackCost);
      const double before = multiplier_[i];
      multiplier_[i] = std::max(0.0, before + lacks / (a.squaredNorm() + 1.0 / kSlackCost));
      x += (multiplier_[i] - before) * a;
      change = std::max(change, std::abs(multiplier_[i] - before) * a.norm());
    }
  }
  return x;
}

}  // namespace baton
