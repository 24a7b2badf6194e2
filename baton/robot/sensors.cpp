#include "baton/robot/sensors.hpp"

namespace baton {

Sensors::Sensors(const SensorErrors& errors, int joints, double period, std::uint64_t seed)
    : errors_(errors), period_(period), random_(seed), encoder_error_(VecX::Zero(joints)) {
  if (errors.glitches > 0.0) glitches_.emplace(errors.glitches, period, seed ^ 0x676c69746368U);
}

double Sensors::encoder(double angle) {
  return angle + (errors_.encoder_noise > 0.0 ? errors_.encoder_noise * noise() : 0.0);
}

void Sensors::disturb(Measurement& measurement) {
  if (errors_.encoder_noise > 0.0) {
    for (Eigen::Index j = 0; j < measurement.q.size(); ++j) {
      const double error = errors_.encoder_noise * noise();
      measurement.q[j] += error;
      measurement.dq[j] += (error - encoder_error_[j]) / period_;
      encoder_error_[j] = error;
    }
  }
  measurement.imu.attitude = rotation_exp(errors_.imu_bias) * measurement.imu.attitude;
  if (errors_.force_noise > 0.0) {
    for (const Side side : kSides) {
      Wrench& sole = measurement.sole[side];
      for (int axis = 0; axis < 3; ++axis) {
        sole.force[axis] *= 1.0 + errors_.force_noise * noise();
        sole.moment[axis] *= 1.0 + errors_.force_noise * noise();
      }
    }
  }
  if (glitches_) glitches_->spoil(measurement);
}

}  // namespace baton
