#include "baton/balance/sensor_check.hpp"

#include <algorithm>
#include <cmath>

#include "baton/balance/check_limits.hpp"

namespace baton {
namespace {

constexpr double kBridge = 0.3;        ///< longest time that a prediction stands in for a sensor [s]
constexpr double kOldest = 0.1;        ///< largest age of a measurement that is taken into account [s]
constexpr double kFastestJoint = 1.5;  ///< largest speed of a joint, as a fall may drive it [no-load speed]
constexpr double kSpeedJump = 12.0;    ///< largest change of a speed in a tick: noise of encoders [rad/s]
constexpr double kAngleStep = 0.035;   ///< change of an angle beyond its speed: noise and backlash [rad]
constexpr double kJointStray = 0.3;    ///< how fast a joint leaves its prediction [rad/s]
constexpr double kStuck = 0.03;        ///< planned movement without a change of the angle [rad]
constexpr double kExcessAngle = 0.04;  ///< speed beyond the change of the angle, added up [rad]

bool finite(const Wrench& wrench) {
  return wrench.force.allFinite() && wrench.moment.allFinite();
}

bool finite(const Measurement& m) {
  return m.q.allFinite() && m.dq.allFinite() && m.imu.attitude.allFinite() && m.imu.rate.allFinite() &&
         m.imu.acceleration.allFinite() && finite(m.sole.left) && finite(m.sole.right);
}

}  // namespace

SensorCheck::SensorCheck(const RobotModel& robot, StateSource source)
    : robot_(&robot),
      period_(robot.profile().tick.period),
      imu_(robot.imu_in_root().value_or(Pose{}), period_),
      forces_(robot),
      joints_(static_cast<std::size_t>(robot.nv() - 6)) {
  used_[Sensor::encoders] = true;
  for (const Sensor sensor : {Sensor::attitude, Sensor::gyro, Sensor::accelerometer})
    used_[sensor] = source != StateSource::perfect;
  used_[Sensor::forces] = source != StateSource::torques;
  used_[Sensor::torques] = source == StateSource::torques;
  last_.q = last_.dq = last_.torque = VecX::Zero(robot.nv() - 6);
  checked_ = last_;
}

const Measurement& SensorCheck::check(const Measurement& measurement, const MotionSample& planned) {
  if (first_) {
    last_ = checked_ = measurement;
    checked_.q = planned.q.tail(robot_->nv() - 6);
    checked_.dq = planned.dq.tail(robot_->nv() - 6);
  }
  checked_.t = measurement.t;
  checked_.age = std::isfinite(measurement.age) ? std::clamp(measurement.age, 0.0, kOldest) : kOldest;
  checked_.root = measurement.root;
  if (repeats(measurement) && planned.dq.norm() > check::kMoves) {
    predict(planned);
    return checked_;
  }
  repeats_ = 0;
  count(Sensor::encoders, check_joints(measurement, planned));
  if (used_[Sensor::gyro]) {
    const ImuCheck::Accepted accepted = imu_.check(measurement.imu, planned);
    count(Sensor::attitude, accepted.attitude);
    count(Sensor::gyro, accepted.gyro);
    count(Sensor::accelerometer, accepted.accelerometer);
    checked_.imu = imu_.imu();
  } else {
    checked_.imu = measurement.imu;
  }
  checked_.torque = measurement.torque;
  checked_.sole = measurement.sole;
  if (used_[Sensor::forces] && !count(Sensor::forces, forces_.forces_accepted(checked_, planned)))
    checked_.sole = forces_.planned_forces(planned);
  if (used_[Sensor::torques] && !count(Sensor::torques, forces_.torques_accepted(measurement.torque)))
    forces_.planned_torques(planned, checked_.torque);
  last_ = measurement;
  first_ = false;
  return checked_;
}

bool SensorCheck::repeats(const Measurement& m) const {
  // What is not finite is the same as nothing, as recordings do not tell infinity from NaN.
  return !first_ && m.q == last_.q && m.dq == last_.dq && m.imu == last_.imu && m.sole == last_.sole && finite(m);
}

void SensorCheck::predict(const MotionSample& planned) {
  const Eigen::Index n = checked_.q.size();
  ++repeats_;
  checked_.q += period_ * planned.dq.tail(n);
  checked_.dq = planned.dq.tail(n);
  for (JointCheck& joint : joints_)
    ++joint.rejected;
  if (used_[Sensor::gyro]) {
    imu_.predict(planned);
    checked_.imu = imu_.imu();
  }
  if (used_[Sensor::forces]) checked_.sole = forces_.planned_forces(planned);
  if (used_[Sensor::torques] && checked_.torque.size() > 0) forces_.planned_torques(planned, checked_.torque);
  for (const Sensor sensor : kSensors) {
    if (used_[sensor] && repeats_ * period_ >= check::kSame) ++rejected_[sensor];
  }
}

bool SensorCheck::check_joints(const Measurement& measurement, const MotionSample& planned) {
  const double leak = 1.0 - period_ / check::kMemory;
  bool all = true;
  for (Eigen::Index j = 0; j < checked_.q.size(); ++j) {
    JointCheck& joint = joints_[static_cast<std::size_t>(j)];
    const double q = measurement.q[j];
    const double dq = measurement.dq[j];
    const double fastest = kFastestJoint * robot_->joints()[static_cast<std::size_t>(j)].motor.no_load;
    const double bridged = joint.rejected * period_;

    // What is not a number fails every comparison.
    const bool in_range = std::abs(dq) <= fastest;
    const bool continuous = in_range && std::abs(dq - checked_.dq[j]) <= kSpeedJump;
    const double expected = checked_.q[j] + period_ * (continuous ? dq : planned.dq[6 + j]);
    const double most = kAngleStep + kJointStray * bridged + (continuous ? 0.0 : period_ * fastest);
    joint.planned = q == last_.q[j] ? joint.planned + period_ * planned.dq[6 + j] : 0.0;
    joint.steady = std::abs(q - last_.q[j]) <= kAngleStep + period_ * fastest ? joint.steady + period_ : 0.0;
    const Range& range = robot_->joints()[static_cast<std::size_t>(j)].position;
    const bool possible = q >= range.lo - check::kBeyondRange && q <= range.hi + check::kBeyondRange;
    const bool angle = possible && std::abs(joint.planned) <= kStuck &&
                       (first_ || std::abs(q - expected) <= most || joint.steady > kBridge);

    const double excess = period_ * dq - (q - checked_.q[j]);
    joint.excess *= leak;
    if (angle && in_range && joint.rejected == 0 && !first_) joint.excess += excess;
    const bool speed = in_range && std::abs(joint.excess) <= kExcessAngle;

    joint.rejected = angle ? 0 : joint.rejected + 1;
    checked_.q[j] = angle ? q : checked_.q[j] + period_ * planned.dq[6 + j];
    checked_.dq[j] = speed ? dq : planned.dq[6 + j];
    all = all && angle && speed;
  }
  return all;
}

bool SensorCheck::count(Sensor sensor, bool accepted) {
  int& ticks = rejected_[sensor];
  ticks = accepted ? 0 : ticks + 1;
  return accepted;
}

Health SensorCheck::health(Sensor sensor) const {
  const int rejected = rejected_[sensor];
  if (rejected == 0) return Health::good;
  return rejected * period_ >= kBridge ? Health::lost : Health::bridged;
}

bool SensorCheck::lost() const {
  return std::any_of(kSensors.begin(), kSensors.end(),
                     [this](Sensor sensor) { return health(sensor) == Health::lost; });
}

}  // namespace baton
