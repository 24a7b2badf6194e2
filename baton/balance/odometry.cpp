#include "baton/balance/odometry.hpp"

#include <fmt/format.h>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr double kDrift = 2.5e-2;  ///< position error per distance walked

}  // namespace

Odometry::Odometry(const RobotModel& robot, const World& world, StateSource source, const Posture& start)
    : robot_(&robot),
      source_(source),
      kinematics_(robot),
      q_(start.q),
      dq_(VecX::Zero(robot.nv())),
      attitude_(robot.imu_in_root().value_or(Pose{}), robot.profile().tick.period, robot.omega()),
      yaw_drift_(robot.profile().tick.period),
      zeros_(robot.mass() * kGravity, robot.profile().stance.com_height, robot.omega() * robot.profile().tick.period),
      imu_(robot.imu_in_root().value_or(Pose{}),
           yaw_of(Eigen::Quaterniond(start.q[3], start.q[4], start.q[5], start.q[6]).toRotationMatrix()),
           robot.profile().tick.period),
      play_(robot),
      speeds_(robot.nv() - 6, robot.profile().tick.period),
      wrenches_(robot),
      contact_(robot.mass() * kGravity, robot.profile().tick.period),
      legs_(robot, start.q.head<3>(), {start.sole.left.p, start.sole.right.p}),
      map_(robot, world) {
  if (source != StateSource::perfect && !robot.imu_in_root()) {
    throw InputError(fmt::format("robot {}: --state {} needs an IMU on the body with the free joint: parts.imu",
                                 robot.profile().name, to_string(source)));
  }
  completed_.q = completed_.dq = completed_.torque = VecX::Zero(robot.nv() - 6);
}

const Measurement& Odometry::update(const Measurement& measurement, const MotionSample& planned) {
  completed_ = measurement;
  if (source_ == StateSource::perfect) {
    contact_.update(measured_or_planned_load(measurement, planned));
    return completed_;
  }
  const int n = robot_->nv() - 6;
  completed_.imu.attitude = attitude_.update(measurement.imu, planned);
  const RootImu::RootMotion imu = imu_.update(completed_.imu);
  if (source_ == StateSource::sensors) zeros_.correct(completed_.sole, planned);
  speeds_.smooth(completed_.dq, planned.dq.tail(n));
  play_.correct(completed_.q, completed_.torque, contact_, planned.contact);
  set_root(q_, {Vec3::Zero(), imu.R});
  q_.tail(n) = completed_.q;
  dq_.segment<3>(3) = imu.rate;
  dq_.tail(n) = completed_.dq;
  kinematics_.set(q_);
  if (source_ == StateSource::torques) {
    completed_.sole = {};  // without measured torques there are no loads
    if (measurement.torque.size() == measurement.q.size()) {
      completed_.sole =
          wrenches_.estimate({q_, dq_, imu.acceleration, imu.R.transpose() * imu.angular_accel, planned.ddq.tail(n)},
                             measurement.torque, planned.contact, kinematics_);
    }
  }
  contact_.update(load_of(completed_.sole));
  yaw_drift_.update({yaw_of(kinematics_.sole(Side::left).R), yaw_of(kinematics_.sole(Side::right).R)}, contact_,
                    planned);
  attitude_.set_yaw_error(yaw_drift_.error());
  legs_.update(kinematics_, dq_, imu.acceleration, contact_, completed_.sole);
  legs_.shift(map_.correction(kinematics_, legs_.foothold(), contact_, planned.contact));
  completed_.root = RootMeasurement{{legs_.place(), imu.R}, legs_.velocity(), imu.rate};
  return completed_;
}

double Odometry::uncertainty() const {
  return kDrift * 0.5 * legs_.walked();
}

BySide<double> Odometry::measured_or_planned_load(const Measurement& measurement, const MotionSample& planned) const {
  // Without force sensors, the planned contacts are assumed.
  const bool senses = !measurement.sole.left.force.isZero(0.0) || !measurement.sole.right.force.isZero(0.0);
  const double each = robot_->mass() * kGravity / (planned.contact.left && planned.contact.right ? 2.0 : 1.0);
  BySide<double> load;
  for (const Side side : kSides)
    load[side] = senses ? measurement.sole[side].force.z() : planned.contact[side] ? each : 0.0;
  return load;
}

BySide<double> Odometry::load_of(const BySide<Wrench>& sole) const {
  BySide<double> load;
  for (const Side side : kSides)
    load[side] = (kinematics_.sole(side).R * sole[side].force).z();
  return load;
}

}  // namespace baton
