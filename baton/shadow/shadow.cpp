#include "baton/shadow/shadow.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "baton/ik/stand.hpp"
#include "baton/link/engage.hpp"
#include "baton/model/error.hpp"
#include "baton/navigate/navigator.hpp"

namespace baton::shadow {
namespace {

constexpr double kStillSpeed = 0.016;  ///< speed of the COM of a robot that stands still [COM height × ω]
constexpr double kStillJoints = 0.1;   ///< speed of its joints [rad/s]
constexpr double kStillLoad = 0.2;     ///< load of each of its soles [weight]
constexpr double kSettles = 0.5;       ///< time after which it stands still [s]
constexpr double kBefore = 0.25;       ///< time of standing still before a motion that is none: it begins slowly [s]
constexpr double kFilter = 0.1;        ///< time constant of the joints' speeds [s]
constexpr double kAgain = 1.0;         ///< time after which the same command is tried again [s]
constexpr std::size_t kMostTried = 1000;
constexpr std::size_t kMostJudged = 1000;
constexpr double kNearRange = 1e-3;  ///< angle beyond a range that is none [rad]

bool usable(const Measurement& m) {
  const Mat3& R = m.imu.attitude;
  return m.q.allFinite() && m.dq.allFinite() && R.allFinite() && (R * R.transpose() - Mat3::Identity()).norm() < 1e-3;
}

}  // namespace

Shadow::Shadow(const RobotModel& robot, const World& world, Parameters parameters)
    : robot_(&robot),
      world_(&world),
      parameters_(parameters),
      strategy_(robot, world, parameters.modes),
      timing_(robot.profile().tick.period),
      standing_(robot, parameters.source),
      kinematics_(robot),
      zero_(VecX::Zero(robot.nv())),
      speed_(VecX::Zero(robot.nv() - 6)) {
  const VecX none = VecX::Zero(robot.nv() - 6);
  commanded_ = {none, none, none, none, {true, true}, {}};
  // For its complaint about sensors that are not there.
  Watch(robot, world, parameters.source, stand(robot, world.site("start"), robot.profile().stance.com_height));
}

void Shadow::tick(const link::Reading& reading, const Truth* truth, const Command& command) {
  const Measurement& measured = reading.measurement;
  const double period = robot_->profile().tick.period;
  const Timing::Kind kind = timing_.take(reading);
  if (kind == Timing::Kind::out_of_order) return;
  if (kind == Timing::Kind::anew) {
    watch_.reset();
    standing_.pause();
    still_ = 0.0;
    pending_.clear();
  }
  damped_ = reading.damped;
  if (damped_) damped_time_ += period;
  look_at_joints(measured);
  if (!watch_ && usable(measured)) begin(measured);
  if (!watch_) {
    unusable_ += period;
    return;
  }
  watch_->estimate(measured, expected_, Pose{});
  judge(truth);
  commanded_.q = watch_->state().q.tail(speed_.size());
  watch_->warm(commanded_);
  hottest_ = std::max(hottest_, watch_->thermometer().hottest().total);
  look_at_sensors(measured);
  expect(measured);
  if (kind == Timing::Kind::repeated) return;
  if (!still()) {
    pending_.clear();
    return standing_.pause();
  }
  pending_.push_back({seconds(), measured, watch_->state()});
  if (static_cast<double>(pending_.size()) * period > kBefore) {
    const Seen& seen = pending_.front();
    standing_.compare(seen.t, seen.measured, seen.state);
    pending_.pop_front();
  }
  try_out(command);
}

void Shadow::begin(const Measurement& measured) {
  const Mat3 root = measured.imu.attitude * robot_->imu_in_root().value_or(Pose{}).R.transpose();
  const Pose start = world_->site("start");
  VecX q = VecX::Zero(robot_->nq());
  q.tail(measured.q.size()) = measured.q;
  set_root(q, {Vec3::Zero(), rotation_z(yaw_of(start.R) - yaw_of(root)) * root});
  const BySide<Pose> sole = posture_of(*robot_, q).sole;
  const Vec3 middle = 0.5 * (sole.left.p + sole.right.p);
  q.head<2>() = (start.p - middle).head<2>();
  q[2] = start.p.z() - std::min(sole.left.p.z(), sole.right.p.z());
  const Posture posture = posture_of(*robot_, q);
  watch_.emplace(*robot_, *world_, parameters_.source, posture);
  if (!start_) start_ = posture;
  expected_ = resting(*robot_, posture);
  speed_.setZero();
}

void Shadow::expect(const Measurement& measured) {
  const State& state = watch_->state();
  const double follows = robot_->profile().tick.period / kFilter;
  if (measured.dq.allFinite()) speed_ += follows * (measured.dq - speed_);
  const double weight = robot_->mass() * kGravity;
  bool stands = watch_->guard() == Guard::armed && !damped_ && speed_.cwiseAbs().maxCoeff() < kStillJoints &&
                state.dcom.norm() < kStillSpeed * robot_->omega() * robot_->profile().stance.com_height;
  for (const Side side : kSides)
    stands = stands && watch_->odometry().load()[side] > kStillLoad * weight;
  still_ = stands ? still_ + robot_->profile().tick.period : 0.0;

  expected_.q = state.q;
  expected_.dq.setZero();
  if (!stands && measured.imu.rate.allFinite())
    expected_.dq.segment<3>(3) = robot_->imu_in_root().value_or(Pose{}).R * measured.imu.rate;
  kinematics_.inverse_dynamics(expected_.q, zero_, zero_, expected_.force);
  expected_.com = state.com;
  expected_.dcom = state.dcom;
  expected_.sole = state.sole;
  const BySide<bool>& touch = watch_->odometry().touch();
  expected_.contact = touch.left || touch.right ? touch : BySide<bool>{true, true};
  expected_.zmp_height = support_plane(expected_.sole, expected_.contact);
  Wrench total;
  for (const Side side : kSides) {
    total.force += state.force[side].force;
    total.moment += state.force[side].moment + state.sole[side].p.cross(state.force[side].force);
  }
  const bool carries = total.force.z() > kStillLoad * weight;
  expected_.zmp = carries ? total.zmp(expected_.zmp_height) : Vec2(state.com.head<2>());
}

bool Shadow::still() const {
  return still_ >= kSettles;
}

void Shadow::judge(const Truth* truth) {
  const Guard before = watch_->guard();
  watch_->judge(expected_, Pose{}, true);
  if (watch_->guard() == Guard::stood_up && watch_->supported()) watch_->arm();
  const Guard now = watch_->guard();
  if (truth != nullptr && truth->fallen && !watch_->soft()) fallen_unnoticed_ += robot_->profile().tick.period;
  if (now == before || judged_.size() >= kMostJudged) return;
  Judged change{seconds(), before, now};
  if (truth != nullptr && now == Guard::fallen) change.truly = truth->fallen;
  if (truth != nullptr && now == Guard::lifted) change.truly = !truth->touch.left && !truth->touch.right;
  judged_.push_back(change);
}

void Shadow::look_at_sensors(const Measurement& measured) {
  BySensor<bool> finite;
  finite[Sensor::encoders] = measured.q.allFinite() && measured.dq.allFinite();
  finite[Sensor::torques] = measured.torque.allFinite();
  finite[Sensor::attitude] = measured.imu.attitude.allFinite();
  finite[Sensor::gyro] = measured.imu.rate.allFinite();
  finite[Sensor::accelerometer] = measured.imu.acceleration.allFinite();
  finite[Sensor::forces] = true;
  for (const Side side : kSides)
    finite[Sensor::forces] =
        finite[Sensor::forces] && measured.sole[side].force.allFinite() && measured.sole[side].moment.allFinite();
  for (const Sensor sensor : kSensors) {
    Rejected& rejected = rejected_[sensor];
    const Health now = watch_->sensors().health(sensor);
    const Health before = std::exchange(rejected.health, now);
    if (now == Health::good) continue;
    if (rejected.ticks++ == 0) rejected.first = seconds();
    if (!finite[sensor]) ++rejected.not_finite;
    if (before == Health::good) ++rejected.times;
    if (now == Health::lost && before != Health::lost) ++rejected.lost;
  }
}

void Shadow::look_at_joints(const Measurement& measured) {
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    const Joint& joint = robot_->joints()[j];
    const auto at = static_cast<Eigen::Index>(j);
    const auto check = [&](const char* what, const char* unit, double value, double limit, bool is_beyond) {
      if (!is_beyond) return;
      const auto same = [&](const Beyond& one) { return one.joint == joint.name && one.what == what; };
      auto known = std::find_if(beyond_.begin(), beyond_.end(), same);
      if (known == beyond_.end()) known = beyond_.insert(known, {joint.name, what, unit, limit});
      if (known->n++ == 0 || std::abs(value - limit) > std::abs(known->value - known->limit)) {
        known->value = value;
        known->limit = limit;
        known->t = seconds();
      }
    };
    const double q = measured.q[at];
    const Range& range = joint.position;
    check("angle", "rad", q, q < range.lo ? range.lo : range.hi,
          q < range.lo - kNearRange || q > range.hi + kNearRange);
    const double dq = measured.dq[at];
    check("speed", "rad/s", dq, std::copysign(joint.motor.no_load, dq), std::abs(dq) > joint.motor.no_load);
    if (measured.torque.size() == 0) continue;
    const double torque = measured.torque[at];
    check("torque", "N·m", torque, std::copysign(joint.motor.stall, torque), std::abs(torque) > joint.motor.stall);
  }
}

void Shadow::try_out(const Command& stick) {
  const Command command = sanitised(stick);
  if (command.neutral() || tried_.size() >= kMostTried) return;
  if (!tried_.empty() && tried_.back().command == command && seconds() - tried_.back().t < kAgain) return;
  Tried& tried = tried_.emplace_back();
  tried.t = seconds();
  tried.command = command;
  const State& state = watch_->state();
  // Where a driver that took over now would begin.
  Pose middle{0.5 * (state.sole.left.p + state.sole.right.p), rotation_z(mean_yaw(state.sole))};
  if (const std::optional<GroundPoint> ground = world_->ground(middle.p.head<2>())) middle.p.z() = ground->height;
  std::optional<Navigator> navigator;
  try {
    const Posture posture = link::engage(*robot_, middle, state.q.tail(speed_.size()));
    navigator.emplace(*robot_, *world_, posture, parameters_.modes.gait, StateSource::perfect);
    Measurement measured;
    measured.q = posture.q.tail(speed_.size());
    measured.dq = measured.torque = VecX::Zero(speed_.size());
    const Mat3 root = Eigen::Quaterniond(posture.q[3], posture.q[4], posture.q[5], posture.q[6]).toRotationMatrix();
    measured.root = RootMeasurement{{posture.q.head<3>(), root}};
    navigator->tick(measured, command);
  } catch (const InputError& error) {
    tried.outcome = Tried::Outcome::refused;
    tried.why = error.what();
    return;
  }
  Request request = navigator->request_for(command);
  request.start.posture.heat = watch_->thermometer().heat();
  const Answer answer = strategy_.plan(request);
  if (const PlannedMotion* planned = answer.planned()) {
    tried.outcome = planned->limit ? Tried::Outcome::in_part : Tried::Outcome::possible;
    tried.duration = planned->motion->duration();
    tried.refusal = planned->limit;
  } else if (const Refusal* refusal = answer.refusal()) {
    tried.outcome = Tried::Outcome::refused;
    tried.refusal = *refusal;
  }
}

}  // namespace baton::shadow
