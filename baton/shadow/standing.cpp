#include "baton/shadow/standing.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace baton::shadow {
namespace {

constexpr double kUnmodelled = 0.03;                  ///< error of a torque beyond friction [stall torque]
constexpr double kLeastAngle = 0.0035;                ///< angle that is not worth a word, 0.2° [rad]
constexpr double kLeastLength = 0.008;                ///< the same for a length [COM height]
constexpr double kSigmas = 2.0;                       ///< of what errors may add up to
constexpr double kGravityError = 0.02;                ///< of an accelerometer's gain
constexpr double kGravityTilt = 0.0087;               ///< of its direction, 0.5° [rad]
constexpr double kLeastShare = 0.01;                  ///< share of the weight that is not worth a word
constexpr double kTorqueWeight = 0.15;                ///< weight by the motor torques: rough, as friction carries too
constexpr double kDrift = 2.0 * M_PI / 180.0 / 60.0;  ///< 2° a minute [rad/s]

const char* const kForceWeight = "weight by the sole forces";
const char* const kTorquesWeight = "weight by the motor torques";
const char* const kComAhead = "COM ahead, by the sole forces";
const char* const kComLeft = "COM to the left, by the sole forces";
const char* const kZmpAhead = "ZMP ahead, torques against forces";
const char* const kZmpLeft = "ZMP to the left, torques against forces";
const char* const kImuRoll = "IMU's roll against the soles";
const char* const kImuPitch = "IMU's pitch against the soles";
const char* const kSolesRoll = "right sole's roll against the left";
const char* const kSolesPitch = "right sole's pitch against the left";
const char* const kSolesHeight = "right sole's height above the left";
const char* const kGravityRoll = "accelerometer's roll against the attitude";
const char* const kGravityPitch = "accelerometer's pitch against the attitude";
const char* const kGravitySize = "accelerometer's size against gravity";

/// Roll and pitch of what is normal to `up`, in a frame of this heading [rad].
Vec2 roll_pitch(const Vec3& up, double heading) {
  const Vec3 n = rotation_z(-heading) * up;
  return {-std::atan2(n.y(), n.z()), std::atan2(n.x(), n.z())};
}

Wrench about_origin(const Pose& sole, const Wrench& wrench) {
  return {wrench.force, wrench.moment + sole.p.cross(wrench.force)};
}

Wrench sum(const BySide<Wrench>& wrench) {
  return {wrench.left.force + wrench.right.force, wrench.left.moment + wrench.right.moment};
}

}  // namespace

Standing::Standing(const RobotModel& robot, StateSource source)
    : robot_(&robot),
      source_(source),
      kinematics_(robot),
      wrenches_(robot),
      zero_(VecX::Zero(robot.nv())),
      force_(VecX::Zero(robot.nv())),
      torque_(VecX::Zero(robot.nv() - 6)) {
  const Profile& profile = robot.profile();
  const SensorErrors& sensors = profile.sensors;
  const double friction = profile.actuators.friction;
  const double weight = robot.mass() * kGravity;
  const double height = profile.stance.com_height;
  double stall = 0.0;
  for (const Joint& joint : robot.joints()) {
    all_.push_back({"torque of " + joint.name, "N·m", (friction + kUnmodelled) * joint.motor.stall,
                    "wrong mass, wrong zero or friction"});
    stall = std::max(stall, joint.motor.stall);
  }
  // Zero errors are uniform, and about three joints of each leg turn a sole about an axis.
  const double zero = std::hypot(sensors.encoder_offset, profile.actuators.backlash);
  const double sole = kSigmas * std::sqrt(2.0) * zero + kLeastAngle;
  const double imu = std::hypot(sensors.imu_mount, 1.5 * zero, 0.5 * sensors.imu_wander) + kLeastAngle;
  const double com =
      height * (sensors.imu_mount + kSigmas * zero + kLeastLength) + sensors.force_zero * profile.stance.width;
  const double zmp = 2.0 * friction * stall / weight + height * kLeastLength;
  const auto number = [&](const char* what, const char* unit, double limit, const char* cause) {
    all_.push_back({what, unit, limit, cause});
  };
  const auto vector = [&](const char* first, const char* second, const char* unit, double limit, const char* cause) {
    all_.push_back({first, unit, limit, cause, 1});
    all_.push_back({second, unit, limit, cause, -1});
  };
  const char* const zeros = "zeros of the leg joints";
  if (source != StateSource::torques) {
    const double share = sensors.force_gain + std::sqrt(2.0) * sensors.force_zero + kLeastShare;
    number(kForceWeight, "N", share * weight, "wrong mass, a payload, or the force sensors' gains or zeros");
    vector(kComAhead, kComLeft, "m", com, "a payload, a wrong COM, the IMU's mount, or zeros of the leg joints");
    vector(kZmpAhead, kZmpLeft, "m", zmp, "zeros or gains of force sensors or motor currents");
  }
  number(kTorquesWeight, "N", kTorqueWeight * weight, "wrong mass, a payload, friction or motor constants");
  vector(kImuRoll, kImuPitch, "rad", imu, "the IMU's mount, zeros of the leg joints, or a floor that is not level");
  vector(kSolesRoll, kSolesPitch, "rad", sole, zeros);
  number(kSolesHeight, "m", height * (kSigmas * zero + kLeastLength), zeros);
  vector(kGravityRoll, kGravityPitch, "rad", kGravityTilt + sensors.imu_wander, "the IMU's attitude or accelerometer");
  number(kGravitySize, "m/s²", kGravityError * kGravity, "the accelerometer's gain or zero");
}

std::vector<Comparison> Standing::disagreements() const {
  std::vector<Comparison> beyond;
  for (const Comparison& one : all_) {
    if (one.value.n == 0) continue;
    const double mean = one.value.mean();
    const double other = one.other != 0 ? (&one)[one.other].value.mean() : 0.0;
    if (std::abs(mean) >= std::abs(other) && std::hypot(mean, other) > one.limit) beyond.push_back(one);
  }
  return beyond;
}

Comparison& Standing::of(std::string_view what) {
  const auto found = std::find_if(all_.begin(), all_.end(), [&](const Comparison& one) { return one.what == what; });
  if (found == all_.end()) throw std::logic_error("not compared: " + std::string(what));
  return *found;
}

void Standing::compare(double t, const Measurement& measured, const State& state) {
  ++ticks_;
  kinematics_.inverse_dynamics(state.q, zero_, zero_, force_);
  if (source_ != StateSource::torques) compare_forces(t, state);
  if (measured.torque.size() == torque_.size()) compare_torques(t, measured, state);
  compare_attitude(t, measured, state);
}

void Standing::compare_forces(double t, const State& state) {
  BySide<Wrench> contact;
  for (const Side side : kSides)
    contact[side] = about_origin(state.sole[side], state.force[side]);
  const Wrench total = sum(contact);
  of(kForceWeight).value.add(total.force.z() - robot_->mass() * kGravity, t);
  const double ground = 0.5 * (state.sole.left.p.z() + state.sole.right.p.z());
  const Vec2 off = Eigen::Rotation2Dd(-mean_yaw(state.sole)) * (total.zmp(ground) - state.com.head<2>());
  of(kComAhead).value.add(off.x(), t);
  of(kComLeft).value.add(off.y(), t);
}

void Standing::compare_torques(double t, const Measurement& measured, const State& state) {
  BySide<Wrench> contact;
  for (const Side side : kSides)
    contact[side] = about_origin(state.sole[side], state.force[side]);
  joint_torques(kinematics_, force_, contact, torque_);
  for (Eigen::Index j = 0; j < torque_.size(); ++j)
    all_[static_cast<std::size_t>(j)].value.add(measured.torque[j] - torque_[j], t);
  BySide<Wrench> legs = wrenches_.by_legs({state.q, zero_, Vec3::Zero(), Vec3::Zero(), zero_.tail(torque_.size())},
                                          measured.torque, kinematics_);
  for (const Side side : kSides) {
    const Mat3& R = state.sole[side].R;
    legs[side] = about_origin(state.sole[side], {R * legs[side].force, R * legs[side].moment});
  }
  const Wrench felt = sum(legs);
  of(kTorquesWeight).value.add(felt.force.z() - robot_->mass() * kGravity, t);
  if (source_ == StateSource::torques) return;
  const double ground = 0.5 * (state.sole.left.p.z() + state.sole.right.p.z());
  const Vec2 off = Eigen::Rotation2Dd(-mean_yaw(state.sole)) * (felt.zmp(ground) - sum(contact).zmp(ground));
  of(kZmpAhead).value.add(off.x(), t);
  of(kZmpLeft).value.add(off.y(), t);
}

void Standing::compare_attitude(double t, const Measurement& measured, const State& state) {
  const Pose imu = robot_->imu_in_root().value_or(Pose{});
  const Mat3 estimated = Eigen::Quaterniond(state.q[3], state.q[4], state.q[5], state.q[6]).toRotationMatrix();
  // The soles as the IMU sees them, by the joints.
  const Mat3 turned = measured.imu.attitude * imu.R.transpose() * estimated.transpose();
  const BySide<Pose> sole{{Vec3::Zero(), turned * state.sole.left.R}, {Vec3::Zero(), turned * state.sole.right.R}};
  const double heading = mean_yaw(sole);
  const Vec3 up = sole.left.R.col(2) + sole.right.R.col(2);
  const Vec2 tilt = roll_pitch(up, heading);
  of(kImuRoll).value.add(tilt.x(), t);
  of(kImuPitch).value.add(tilt.y(), t);
  const Mat3 relative = state.sole.left.R.transpose() * state.sole.right.R;
  const Vec2 other = roll_pitch(relative.col(2), 0.0);
  of(kSolesRoll).value.add(other.x(), t);
  of(kSolesPitch).value.add(other.y(), t);
  const Vec3 normal = (state.sole.left.R.col(2) + state.sole.right.R.col(2)).normalized();
  of(kSolesHeight).value.add(normal.dot(state.sole.right.p - state.sole.left.p), t);
  const Vec2 gravity = roll_pitch(measured.imu.attitude * measured.imu.acceleration, heading);
  of(kGravityRoll).value.add(gravity.x(), t);
  of(kGravityPitch).value.add(gravity.y(), t);
  of(kGravitySize).value.add(measured.imu.acceleration.norm() - kGravity, t);
  if (!std::isfinite(heading)) return;
  if (line_.n == 0.0) {
    line_.first = heading;
    line_.began = t;
  }
  const double since = t - line_.began;
  const double y = wrap_angle(heading - line_.first);
  line_.n += 1.0;
  line_.t += since;
  line_.y += y;
  line_.tt += since * since;
  line_.ty += since * y;
}

Standing::Drift Standing::drift() const {
  if (line_.n <= 1.0) return drift_;
  return {drift_.time + robot_->profile().tick.period * line_.n, drift_.tt + line_.tt - line_.t * line_.t / line_.n,
          drift_.ty + line_.ty - line_.t * line_.y / line_.n};
}

void Standing::pause() {
  drift_ = drift();
  line_ = {};
}

double Standing::seconds() const {
  return static_cast<double>(ticks_) * robot_->profile().tick.period;
}

double Standing::yaw_drift() const {
  const Drift known = drift();
  return known.time >= kDrifting ? known.ty / known.tt : 0.0;
}

double Standing::yaw_drift_limit() const {
  return robot_->profile().sensors.yaw_drift + kDrift;
}

}  // namespace baton::shadow
