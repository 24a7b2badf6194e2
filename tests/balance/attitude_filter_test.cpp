#include "baton/balance/attitude_filter.hpp"

#include <gtest/gtest.h>

#include <random>

namespace baton {
namespace {

constexpr double kPeriod = 0.005;
constexpr double kOmega = 6.14;

/// A sensor that turns smoothly, on a robot that follows its plan.
class TurningSensor {
 public:
  explicit TurningSensor(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto vector = [&](double size) {
      const double x = unit(random);
      const double y = unit(random);
      return Vec3(size * x, size * y, size * unit(random));
    };
    start_ = rotation_exp(vector(0.3));
    rate_ = vector(0.3);
    phase_ = vector(M_PI);
    planned.q = VecX::Zero(8);
    planned.q[3] = 1.0;
    planned.dq = planned.ddq = VecX::Zero(7);
    imu.attitude = start_;
    read();
  }

  /// The next reading.
  void advance() {
    const Vec3 now = (kPeriod * static_cast<double>(++tick_) * Vec3::Ones() + phase_).array().cos();
    imu.rate = rate_.cwiseProduct(now);
    imu.attitude = imu.attitude * rotation_exp(kPeriod * imu.rate);
    read();
  }

  Measurement::Imu imu;
  MotionSample planned;

 private:
  void read() {
    const double t = kPeriod * static_cast<double>(tick_);
    planned.ddq.head<3>() = Vec3(std::sin(5.0 * t), std::cos(4.0 * t), 0.5 * std::sin(7.0 * t));
    const double yaw = yaw_of(imu.attitude);
    imu.acceleration = imu.attitude.transpose() * (rotation_z(yaw) * (planned.ddq.head<3>() + Vec3(0, 0, kGravity)));
  }

  Mat3 start_;
  Vec3 rate_;
  Vec3 phase_;
  long tick_ = 0;
};

TEST(AttitudeFilter, ASensorWithoutErrorsIsBelieved) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    TurningSensor sensor(seed);
    AttitudeFilter filter({}, kPeriod, kOmega);
    for (int tick = 0; tick < 1000; ++tick) {
      ASSERT_LT(rotation_error(filter.update(sensor.imu, sensor.planned), sensor.imu.attitude).norm(), 1e-9)
          << "seed " << seed << ", tick " << tick;
      sensor.advance();
    }
  }
}

TEST(AttitudeFilter, OfARollAndPitchThatWanderLittleIsLeft) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    TurningSensor sensor(seed);
    AttitudeFilter filter({}, kPeriod, kOmega);
    double wandered = 0.0;
    double left = 0.0;
    for (int tick = 0; tick < 8000; ++tick) {
      const double t = kPeriod * tick;
      const double slow = static_cast<double>(seed % 5 + 1);
      const Vec3 error = 0.035 * Vec3(std::sin(1.2 * t / slow), std::sin(1.0 * t / slow), 0.0);
      Measurement::Imu imu = sensor.imu;
      imu.attitude = rotation_exp(error) * imu.attitude;
      const Vec3 off = rotation_error(filter.update(imu, sensor.planned), sensor.imu.attitude);
      wandered += error.squaredNorm();
      left += off.head<2>().squaredNorm();
      sensor.advance();
    }
    EXPECT_LT(std::sqrt(left / wandered), 0.35) << "seed " << seed;
  }
}

TEST(AttitudeFilter, OneFaultyReadingOfGyroOrAccelerometerDoesLittle) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    TurningSensor sensor(seed);
    AttitudeFilter filter({}, kPeriod, kOmega);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    double off = 0.0;
    for (int tick = 0; tick < 200; ++tick) {
      Measurement::Imu imu = sensor.imu;
      if (tick == 100 && seed % 2 == 0) imu.rate += 7.0 * Vec3(unit(random), unit(random), unit(random));
      if (tick == 100 && seed % 2 == 1) imu.acceleration += 100.0 * Vec3(unit(random), unit(random), unit(random));
      off = std::max(off, rotation_error(filter.update(imu, sensor.planned), sensor.imu.attitude).norm());
      sensor.advance();
    }
    EXPECT_LT(off, 2e-3) << "seed " << seed;
  }
}

TEST(AttitudeFilter, TheYawIsTheSensorsButForItsDrift) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    TurningSensor sensor(seed);
    AttitudeFilter filter({}, kPeriod, kOmega);
    double off = 0.0;
    constexpr int kTicks = 2000;
    for (int tick = 0; tick < kTicks; ++tick) {
      Measurement::Imu imu = sensor.imu;
      const double drifted = 0.003 * kPeriod * tick;
      imu.attitude = rotation_z(drifted) * imu.attitude;
      filter.set_yaw_error(drifted);
      off = wrap_angle(yaw_of(filter.update(imu, sensor.planned)) - yaw_of(sensor.imu.attitude));
      sensor.advance();
    }
    EXPECT_LT(std::abs(off), 1e-6) << "seed " << seed;
  }
}

}  // namespace
}  // namespace baton
