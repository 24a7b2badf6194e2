#include "baton/guide/arm_trajectory.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr double kHorizon = 2.0;            ///< length of a path, for any robot [s]
constexpr double kLongestMotion = 1.0;      ///< duration of a motion of the arms alone [s]
constexpr double kGain = 8.0;               ///< of the governor: speed over distance to the target [1/s]
constexpr double kSpeedLag = 0.03;          ///< its lags of speed and acceleration [s]
constexpr double kAccelerationLag = 0.015;  ///< [s]
constexpr double kSpeedShare = 0.5;         ///< of a joint's speed limit
constexpr double kAccelerationShare = 0.15;
constexpr double kShortestBraking = 0.1;  ///< [s]
constexpr double kPeakOfBraking = 1.5;    ///< largest deceleration of the brake [speed / time of braking]
constexpr double kSettled = 1e-3;         ///< speed at which a joint counts as at rest [rad/s]
constexpr double kWithinMargin = 0.01;    ///< by which targets stay within the margin [rad]

/// @throws InputError no joint of an arm has that name
int arm_joint(const RobotModel& robot, const std::string& name) {
  for (const Side side : kSides) {
    for (const int j : robot.arm(side)) {
      if (robot.joints()[static_cast<std::size_t>(j)].name == name) return j;
    }
  }
  throw InputError(fmt::format("joint {:?} is none of an arm of {}: must be one of {}", name, robot.profile().name,
                               fmt::join(released_arms(robot).joints, ", ")));
}

}  // namespace

ArmTargets released_arms(const RobotModel& robot) {
  ArmTargets targets;
  for (const Side side : kSides) {
    for (const int j : robot.arm(side))
      targets.joints.push_back(robot.joints()[static_cast<std::size_t>(j)].name);
  }
  return targets;
}

ArmTrajectory::ArmTrajectory(const RobotModel& robot) : robot_(&robot), points_(robot.joints().size()) {}

ArmTrajectory ArmTrajectory::continued(const ArmTargets& targets, double now, const VecX& q) const {
  const std::vector<double>& t = targets.t;
  const auto columns = static_cast<Eigen::Index>(targets.joints.size());
  if (columns == 0 && !t.empty()) throw InputError("targets for no joints: must name at least one");
  if (t.size() > kMostNumbers) throw InputError(fmt::format("{} times: must be at most {}", t.size(), kMostNumbers));
  if (targets.q.rows() != static_cast<Eigen::Index>(t.size()) || (!t.empty() && targets.q.cols() != columns)) {
    throw InputError(
        fmt::format("the targets are {} × {} numbers: must be {} × {}, a row for each time and a column "
                    "for each joint",
                    targets.q.rows(), targets.q.cols(), t.size(), columns));
  }
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (!std::isfinite(t[i]) || (i > 0 && t[i] <= t[i - 1]))
      throw InputError(
          fmt::format("time {} of the targets is {}: must be finite, and later than the one before", i, t[i]));
  }
  if (!targets.q.allFinite()) throw InputError("a target is not finite");
  const double margin = robot_->profile().margin.joint + kWithinMargin;
  ArmTrajectory next = *this;
  ++next.version_;
  std::vector<int> seen;
  for (Eigen::Index column = 0; column < columns; ++column) {
    const std::string& name = targets.joints[static_cast<std::size_t>(column)];
    const int j = arm_joint(*robot_, name);
    if (std::ranges::find(seen, j) != seen.end()) throw InputError(fmt::format("joint {:?} is named twice", name));
    seen.push_back(j);
    std::vector<Point>& points = next.points_[static_cast<std::size_t>(j)];
    if (t.empty()) {
      points.clear();
      continue;
    }
    const double here = points.empty() ? q[j] : next.at(j, now);
    std::erase_if(points, [&](const Point& point) { return point.t <= now || point.t >= t.front(); });
    points.insert(points.begin(), {now, here});
    const Range& range = robot_->joints()[static_cast<std::size_t>(j)].position;
    const double lo = std::min(range.lo + margin, 0.5 * (range.lo + range.hi));
    const double hi = std::max(range.hi - margin, 0.5 * (range.lo + range.hi));
    Point last;
    for (std::size_t i = 0; i < t.size(); ++i) {
      const Point point{t[i], std::clamp(targets.q(static_cast<Eigen::Index>(i), column), lo, hi)};
      if (point.t <= now) {
        points.front().q = point.q;  // it should be there by now
      } else {
        if (i > 0 && last.t < now)  // or on the way
          points.front().q = last.q + (now - last.t) / (point.t - last.t) * (point.q - last.q);
        points.push_back(point);
      }
      last = point;
    }
  }
  std::size_t known = 0;
  for (const std::vector<Point>& points : next.points_)
    known += points.size();
  if (known > kMostNumbers)
    throw InputError(fmt::format("{} targets would be known of the joints: must be at most {}", known, kMostNumbers));
  return next;
}

bool ArmTrajectory::empty() const {
  return std::ranges::all_of(points_, [](const auto& points) { return points.empty(); });
}

double ArmTrajectory::at(int joint, double t) const {
  const std::vector<Point>& points = points_[static_cast<std::size_t>(joint)];
  const auto after = std::ranges::upper_bound(points, t, {}, &Point::t);
  if (after == points.begin()) return after->q;
  const Point& before = *std::prev(after);
  if (after == points.end()) return before.q;
  return before.q + (t - before.t) / (after->t - before.t) * (after->q - before.q);
}

std::shared_ptr<const ArmPath> ArmTrajectory::governed(const Posture& from, double start) const {
  if (empty()) return nullptr;
  const double dt = robot_->profile().tick.period;
  const int last = static_cast<int>(std::ceil(kHorizon / dt));
  auto path = std::make_shared<ArmPath>();
  path->version = version_;
  path->period = dt;
  for (std::size_t j = 0; j < points_.size(); ++j) {
    if (!points_[j].empty()) path->joints.push_back(static_cast<int>(j));
  }
  const auto rows = static_cast<Eigen::Index>(path->joints.size());
  for (MatX* matrix : {&path->q, &path->dq, &path->ddq})
    matrix->setZero(rows, last + 1);
  path->until.setConstant(rows, kHorizon);
  const double most = kAccelerationShare * robot_->profile().margin.acceleration;
  path->braking = kShortestBraking;
  int moves = 0;  // last column in which something moves
  for (Eigen::Index row = 0; row < rows; ++row) {
    const int j = path->joints[static_cast<std::size_t>(row)];
    const double speed = kSpeedShare * robot_->joints()[static_cast<std::size_t>(j)].speed;
    double q = from.q[7 + j];
    double v = from.dq[6 + j];
    double a = from.ddq[6 + j];
    for (int k = 0;; ++k) {
      path->q(row, k) = q;
      path->dq(row, k) = v;
      path->ddq(row, k) = a;
      path->braking = std::max(path->braking, kPeakOfBraking * std::abs(v) / most);
      if (std::abs(v) > kSettled) moves = std::max(moves, k);
      if (k == last) break;
      // The targets are known ahead, so the lags need not show: the speed is that of the target when they are over.
      const double t = start + k * dt;
      const double ahead = t + kSpeedLag + kAccelerationLag;
      const double target_speed = (at(j, ahead + dt) - at(j, ahead - dt)) / (2.0 * dt);
      const double wanted = std::clamp(target_speed + kGain * (at(j, t) - q), -speed, speed);
      const double towards = std::clamp((wanted - v) / kSpeedLag, -most, most);
      const double next = a + (1.0 - std::exp(-dt / kAccelerationLag)) * (towards - a);
      q += dt * (v + dt * (a / 3.0 + next / 6.0));
      v += 0.5 * dt * (a + next);
      a = next;
    }
  }
  path->duration = std::min(moves * dt + path->braking, kLongestMotion);
  return path;
}

}  // namespace baton
