#include "baton/robot/sensors.hpp"

#include <cmath>

namespace baton {
namespace {

constexpr double kFastest = 4.0;   ///< shortest period of a wandering error [s]
constexpr double kSlowest = 20.0;  ///< longest [s]
constexpr double kAside = 0.1;     ///< horizontal zero errors of force sensors against the vertical one

double uniform(std::mt19937_64& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

}  // namespace

double Sensors::Wander::at(double t) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < kWaves; ++k)
    sum += std::sin(rate[k] * t + phase[k]);
  return sum * std::sqrt(2.0 / kWaves);
}

Sensors::Sensors(const SensorErrors& errors, int joints, double period, double weight, std::uint64_t seed)
    : errors_(errors),
      period_(period),
      random_(seed),
      jitter_(seed ^ 0x6a6974746572U),
      encoder_error_(VecX::Zero(joints)),
      encoder_offset_(VecX::Zero(joints)) {
  // The constant errors have a stream of their own, so that each stays the same whatever the others are.
  std::mt19937_64 drawn(seed ^ 0x636f6e7374616e74U);
  const auto axis = [&drawn] { return uniform(drawn, -1.0, 1.0); };
  for (double& offset : encoder_offset_)
    offset = errors.encoder_offset * axis();
  const double way = M_PI * axis();
  mount_ = rotation_exp(errors.imu_mount * Vec3(std::cos(way), std::sin(way), 0.0));
  for (Wander& wander : wander_) {
    for (std::size_t k = 0; k < Wander::kWaves; ++k) {
      wander.rate[k] = 2.0 * M_PI / uniform(drawn, kFastest, kSlowest);
      wander.phase[k] = M_PI * axis();
    }
  }
  yaw_drift_ = axis() < 0.0 ? -errors.yaw_drift : errors.yaw_drift;
  for (const Side side : kSides) {
    force_gain_[side] = 1.0 + errors.force_gain * axis();
    const Vec3 zero(kAside * axis(), kAside * axis(), axis());
    force_zero_[side] = errors.force_zero * weight * zero;
  }
  if (errors.glitches > 0.0) glitches_.emplace(errors.glitches, period, seed ^ 0x676c69746368U);
}

Vec3 Sensors::noise_vector(double deviation) {
  const double x = noise();
  const double y = noise();
  return deviation * Vec3(x, y, noise());
}

double Sensors::quantised(double angle) const {
  return errors_.encoder_step > 0.0 ? errors_.encoder_step * std::round(angle / errors_.encoder_step) : angle;
}

double Sensors::encoder(std::size_t joint, double angle) {
  const double noisy = angle + (errors_.encoder_noise > 0.0 ? errors_.encoder_noise * noise() : 0.0);
  return quantised(noisy + encoder_offset_[static_cast<Eigen::Index>(joint)]);
}

double Sensors::age() {
  return errors_.delay + (errors_.jitter > 0.0 ? uniform(jitter_, 0.0, errors_.jitter) : 0.0);
}

void Sensors::disturb(Measurement& measurement) {
  disturb_joints(measurement);
  disturb_imu(measurement);
  disturb_forces(measurement);
  if (glitches_) glitches_->spoil(measurement);
}

void Sensors::disturb_joints(Measurement& measurement) {
  if (errors_.encoder_noise > 0.0) {
    for (Eigen::Index j = 0; j < measurement.q.size(); ++j) {
      const double error = errors_.encoder_noise * noise();
      measurement.q[j] += error;
      measurement.dq[j] += (error - encoder_error_[j]) / period_;
      encoder_error_[j] = error;
    }
  }
  for (Eigen::Index j = 0; j < measurement.q.size(); ++j)
    measurement.q[j] = quantised(measurement.q[j] + encoder_offset_[j]);
  if (!errors_.differenced_speeds) return;
  if (last_angles_.size() > 0) {
    const double elapsed = measurement.t - last_time_;
    if (elapsed > 0.0) last_speeds_ = (measurement.q - last_angles_) / elapsed;
    measurement.dq = last_speeds_;
  } else {
    last_speeds_ = measurement.dq;
  }
  last_angles_ = measurement.q;
  last_time_ = measurement.t;
}

void Sensors::disturb_imu(Measurement& measurement) {
  Measurement::Imu& imu = measurement.imu;
  if (errors_.yaw_drift > 0.0) {
    imu.rate += yaw_drift_ * imu.attitude.row(2).transpose();
    imu.attitude = rotation_z(yaw_drift_ * measurement.t) * imu.attitude;
  }
  if (errors_.imu_wander > 0.0) {
    const Vec3 error(wander_[0].at(measurement.t), wander_[1].at(measurement.t), 0.0);
    imu.attitude = rotation_exp(errors_.imu_wander * error) * imu.attitude;
  }
  imu.attitude = rotation_exp(errors_.imu_bias) * imu.attitude;
  if (errors_.imu_mount > 0.0)
    imu = {imu.attitude * mount_, mount_.transpose() * imu.rate, mount_.transpose() * imu.acceleration};
  if (errors_.gyro_noise > 0.0) imu.rate += noise_vector(errors_.gyro_noise);
  if (errors_.accelerometer_noise > 0.0) imu.acceleration += noise_vector(errors_.accelerometer_noise);
}

void Sensors::disturb_forces(Measurement& measurement) {
  for (const Side side : kSides) {
    Wrench& sole = measurement.sole[side];
    if (errors_.force_noise > 0.0) {
      for (int axis = 0; axis < 3; ++axis) {
        sole.force[axis] *= 1.0 + errors_.force_noise * noise();
        sole.moment[axis] *= 1.0 + errors_.force_noise * noise();
      }
    }
    if (errors_.force_gain > 0.0) sole = {force_gain_[side] * sole.force, force_gain_[side] * sole.moment};
    sole.force += force_zero_[side];
  }
}

}  // namespace baton
