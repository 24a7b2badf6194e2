#include "baton/balance/odometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr double kTouches = 0.05;   ///< share of the weight from which a sole counts as touching
constexpr double kLeaves = 0.025;   ///< share below which it does no more
constexpr double kTrust = 20.0;     ///< rate at which the velocity follows the soles that stand [1/s]
constexpr double kSmooth = 40.0;    ///< rate at which the joints' speeds follow the measured ones [1/s]
constexpr double kRelax = 10.0;     ///< rate at which a foothold follows where a sole with no load is [1/s]
constexpr double kMap = 1.0;        ///< rate at which heights follow those of the ground [1/s]
constexpr double kDrift = 1e-3;     ///< error of the place, of the way gone
constexpr double kInTheAir = 0.1;   ///< time without a touch from which the height is lost [s]
constexpr double kOnTheMap = 0.05;  ///< farther from the known ground a sole stands on something else [COM height]

// A sole that stands on an edge of the ground. Lengths are shares of the COM height.
constexpr double kTilted = 0.08;   ///< against the ground; a floor may be tilted by less [rad]
constexpr double kOverlap = 0.01;  ///< so much of it is on the edge
constexpr double kRaised = 0.02;   ///< least height of a step that counts
constexpr double kAsHigh = 0.015;  ///< a corner stands on what differs by less in height
constexpr double kFeels = 0.05;    ///< the edge is no farther from where it should be
constexpr double kMoves = 0.04;    ///< how fast the place is corrected [1/s]

}  // namespace

Odometry::Odometry(const RobotModel& robot, const World& world, StateSource source, const Posture& start)
    : robot_(&robot),
      world_(&world),
      source_(source),
      period_(robot.profile().tick.period),
      kinematics_(robot),
      jacobian_(6, robot.nv()),
      q_(start.q),
      dq_(VecX::Zero(robot.nv())),
      ddq_(VecX::Zero(robot.nv())),
      force_(VecX::Zero(robot.nv())),
      speed_error_(VecX::Zero(robot.nv() - 6)),
      place_(start.q.head<3>()) {
  if (source != StateSource::perfect && !robot.imu_in_root()) {
    throw InputError(fmt::format("robot {}: --state {} needs an IMU on the body with the free joint: parts.imu",
                                 robot.profile().name, to_string(source)));
  }
  for (const Side side : kSides) {
    footfall_[side] = foothold_[side] = start.sole[side].p;
    corners_[side] = robot.sole(side).inset(kOverlap * robot.profile().stance.com_height).vertices();
  }
  completed_.q = completed_.dq = completed_.torque = speed_error_;
}

const Measurement& Odometry::update(const Measurement& measurement, const MotionSample& planned) {
  completed_ = measurement;
  if (source_ == StateSource::perfect) {
    // Without sensors under the soles, it is taken to stand as planned.
    const bool senses = !measurement.sole.left.force.isZero(0.0) || !measurement.sole.right.force.isZero(0.0);
    const double each = robot_->mass() * kGravity / (planned.contact.left && planned.contact.right ? 2.0 : 1.0);
    for (const Side side : kSides)
      load_[side] = senses ? measurement.sole[side].force.z() : planned.contact[side] ? each : 0.0;
    note_touch();
    return completed_;
  }
  const Pose& sensor = *robot_->imu_in_root();
  if (first_) {
    const Mat3 start = Eigen::Quaterniond(q_[3], q_[4], q_[5], q_[6]).toRotationMatrix();
    yaw_ = rotation_z(yaw_of(start) - yaw_of(measurement.imu.attitude * sensor.R.transpose()));
  }
  RootMeasurement& root = completed_.root.emplace();
  root.pose.R = yaw_ * measurement.imu.attitude * sensor.R.transpose();
  root.rate = sensor.R * measurement.imu.rate;

  // Acceleration of the root, from that of the sensor.
  const Vec3 rate = root.pose.R * root.rate;
  const Vec3 drate = first_ ? Vec3(Vec3::Zero()) : Vec3((rate - rate_before_) / period_);
  const Vec3 lever = root.pose.R * sensor.p;
  const Vec3 ddroot = root.pose.R * sensor.R * measurement.imu.acceleration - Vec3(0, 0, kGravity) -
                      drate.cross(lever) - rate.cross(rate.cross(lever));
  rate_before_ = rate;

  smooth_speeds(measurement, planned);
  set_root(q_, {Vec3::Zero(), root.pose.R});
  q_.tail(robot_->nv() - 6) = measurement.q;
  dq_.segment<3>(3) = root.rate;
  dq_.tail(robot_->nv() - 6) = completed_.dq;
  kinematics_.set(q_);
  measure_soles(measurement, planned, ddroot, drate);
  const BySide<bool> touched = touch_;
  note_touch();

  // Where the soles that stand say that the root is, and how fast it moves.
  BySide<Vec3> from_root, moves;
  for (const Side side : kSides) {
    from_root[side] = kinematics_.sole(side).p;
    kinematics_.point_jacobian(robot_->foot_body(side), from_root[side], jacobian_.topRows(3));
    moves[side].noalias() = jacobian_.topRows(3) * dq_;
  }
  velocity_ += period_ * ddroot;
  double total = 0.0;
  for (const Side side : kSides)
    total += touch_[side] ? load_[side] : 0.0;
  if (total > 0.0) {
    Vec3 place = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    for (const Side side : kSides) {
      const double share = touch_[side] ? load_[side] / total : 0.0;
      place += share * (foothold_[side] - from_root[side]);
      velocity -= share * moves[side];
    }
    place_ = place;
    velocity_ += first_ ? Vec3(velocity - velocity_) : Vec3(period_ * kTrust * (velocity - velocity_));
  } else {
    place_ += period_ * velocity_;
  }
  for (const Side side : kSides) {
    const double share = touch_[side] ? load_[side] / total : 0.0;
    const double follows = touch_[side] ? (1.0 - share) * std::min(1.0, period_ * kRelax) : 1.0;
    foothold_[side] += follows * (place_ + from_root[side] - foothold_[side]);
    if (!touch_[side]) continue;
    if (!touched[side]) gone_ += (foothold_[side] - footfall_[side]).head<2>().norm();
    footfall_[side] = foothold_[side];
  }
  untouched_ = total > 0.0 ? 0.0 : untouched_ + period_;
  lost_ = lost_ || untouched_ > kInTheAir;
  follow_map(planned);
  root.pose.p = place_;
  root.velocity = velocity_;
  first_ = false;
  return completed_;
}

double Odometry::uncertainty() const {
  return kDrift * 0.5 * gone_;
}

void Odometry::smooth_speeds(const Measurement& measurement, const MotionSample& planned) {
  const auto as_planned = planned.dq.tail(robot_->nv() - 6);
  const double follows = std::min(1.0, period_ * kSmooth);
  speed_error_ += follows * (measurement.dq - as_planned - speed_error_);
  completed_.dq = as_planned + speed_error_;
}

void Odometry::measure_soles(const Measurement& measurement, const MotionSample& planned, const Vec3& ddroot,
                             const Vec3& drate) {
  if (source_ == StateSource::torques) completed_.sole = {};  // not told: it carries nothing
  if (source_ == StateSource::torques && measurement.torque.size() == measurement.q.size()) {
    // Of each leg: what inverse dynamics asks of its joints and the motors do not give comes from the ground.
    ddq_.head<3>() = ddroot;
    ddq_.segment<3>(3) = completed_.root->pose.R.transpose() * drate;
    ddq_.tail(robot_->nv() - 6) = planned.ddq.tail(robot_->nv() - 6);
    kinematics_.inverse_dynamics(q_, dq_, ddq_, force_);
    for (const Side side : kSides) {
      const Pose sole = kinematics_.sole(side);
      kinematics_.sole_jacobian(side, jacobian_);
      Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
      Vec6 asked = Vec6::Zero();
      for (const int j : robot_->leg(side)) {
        const Vec6 column = jacobian_.col(6 + j);
        const double damping = robot_->joints()[static_cast<std::size_t>(j)].motor.damping;
        gram += column * column.transpose();
        asked += column * (force_[6 + j] + damping * dq_[6 + j] - measurement.torque[j]);
      }
      const Vec6 wrench = gram.ldlt().solve(asked);
      if (!wrench.allFinite()) continue;
      completed_.sole[side] = {sole.R.transpose() * wrench.head<3>(), sole.R.transpose() * wrench.tail<3>()};
    }
  }
  for (const Side side : kSides)
    load_[side] = (kinematics_.sole(side).R * completed_.sole[side].force).z();
}

void Odometry::note_touch() {
  const double weight = robot_->mass() * kGravity;
  for (const Side side : kSides)
    touch_[side] = load_[side] > (touch_[side] ? kLeaves : kTouches) * weight;
}

void Odometry::follow_map(const MotionSample& planned) {
  const double height = robot_->profile().stance.com_height;
  double off = 0.0;
  double stand = 0.0;
  Vec2 moved = Vec2::Zero();
  for (const Side side : kSides) {
    if ((!planned.contact[side] && !lost_) || !touch_[side]) continue;
    const std::optional<GroundPoint> ground = world_->ground(foothold_[side].head<2>());
    if (!ground) continue;
    if (const std::optional<Vec2> way = felt_edge(side, *ground)) {  // its height says nothing
      moved += bounded(*way, period_ * kMoves * height);
      continue;
    }
    const double gap = ground->height - foothold_[side].z();
    if (std::abs(gap) > kOnTheMap * height && !lost_) continue;
    off += load_[side] * gap;
    stand += load_[side];
  }
  const double rise = stand > 0.0 ? off / stand : 0.0;
  // The height of a robot that was lifted, or fell, is lost: once a sole lies on the ground again, it is the map's.
  const bool found = lost_ && stand > 0.0;
  if (found) lost_ = false;
  const Vec3 shift(moved.x(), moved.y(), found ? rise : period_ * kMap * rise);
  place_ += shift;
  for (const Side side : kSides)
    foothold_[side] += shift;
}

std::optional<Vec2> Odometry::felt_edge(Side side, const GroundPoint& below) const {
  const double size = robot_->profile().stance.com_height;
  const Mat3 R = kinematics_.sole(side).R;
  if (R.col(2).dot(below.normal) > std::cos(kTilted)) return std::nullopt;
  std::optional<Vec2> way;
  double lowest = below.height;
  double highest = below.height;
  for (const Vec2& vertex : corners_[side]) {
    const Vec3 corner = foothold_[side] + R * Vec3(vertex.x(), vertex.y(), 0.0);
    const Vec2 at = corner.head<2>();
    const std::optional<GroundPoint> ground = world_->ground(at);
    if (!ground) continue;
    lowest = std::min(lowest, ground->height);
    highest = std::max(highest, ground->height);
    if (corner.z() - ground->height < kRaised * size) continue;
    const std::optional<Vec2> edge = world_->nearest_of_height(at, corner.z(), kAsHigh * size);
    if (!edge || (*edge - at).norm() > kFeels * size) continue;
    if (!way || (*edge - at).norm() < way->norm()) way = *edge - at;
  }
  if (way) return way;
  return highest - lowest > kRaised * size ? std::optional<Vec2>(Vec2::Zero()) : std::nullopt;
}

}  // namespace baton
