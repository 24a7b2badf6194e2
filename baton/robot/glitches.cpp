#include "baton/robot/glitches.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace baton {
namespace {

constexpr double kLongest = 0.3;         ///< longest fault [s]
constexpr double kSmallestSpike = 0.01;  ///< [rad, rad/s, m/s², N, N·m]
constexpr double kLargestSpike = 1e4;    ///< the same; that of an attitude is π

/// The numbers of a reading.
std::vector<double*> numbers(Measurement& m, Reading reading) {
  std::vector<double*> list;
  const auto add = [&list](auto& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i)
      list.push_back(values.data() + i);
  };
  switch (reading) {
    case Reading::angles:
      add(m.q);
      break;
    case Reading::speeds:
      add(m.dq);
      break;
    case Reading::torques:
      add(m.torque);
      break;
    case Reading::attitude:
      add(m.imu.attitude);
      break;
    case Reading::gyro:
      add(m.imu.rate);
      break;
    case Reading::accelerometer:
      add(m.imu.acceleration);
      break;
    case Reading::forces:
      for (const Side side : kSides) {
        add(m.sole[side].force);
        add(m.sole[side].moment);
      }
      break;
  }
  return list;
}

}  // namespace

Glitches::Glitches(double interval, double period, std::uint64_t seed)
    : interval_(interval), period_(period), random_(seed) {
  wait_ = std::lround(uniform(0.2, 1.0) * interval_ / period_);
}

void Glitches::spoil(Measurement& measurement) {
  if (left_ > 0) --left_;
  if (left_ == 0 && --wait_ <= 0) begin(measurement);
  if (left_ == 0) return;
  if (fault_ == Fault::held) {
    measurement = before_;
    return;
  }
  const std::vector<double*> list = numbers(measurement, reading_);
  if (list.empty()) return;
  const auto set = [&](double value) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (all_ || i == one_) *list[i] = value;
    }
  };
  switch (fault_) {
    case Fault::nan:
      set(std::numeric_limits<double>::quiet_NaN());
      break;
    case Fault::infinite:
      set(std::copysign(std::numeric_limits<double>::infinity(), size_));
      break;
    case Fault::spike:
      if (reading_ == Reading::attitude)
        measurement.imu.attitude = turn_ * measurement.imu.attitude;
      else
        *list[one_] += size_;
      break;
    case Fault::stuck: {
      const std::vector<double*> old = numbers(before_, reading_);
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (all_ || i == one_) *list[i] = *old[i];
      }
      break;
    }
    case Fault::exchanged:
      if (reading_ == Reading::forces)
        std::swap(measurement.sole.left, measurement.sole.right);
      else
        std::swap(*list[one_], *list[other_]);
      break;
    case Fault::held:
      break;
  }
}

void Glitches::begin(Measurement& measurement) {
  wait_ = std::lround(uniform(0.2, 1.0) * interval_ / period_);
  const double ticks = std::max(1.0, kLongest / period_);
  left_ = std::lround(std::pow(ticks, uniform(0.0, 1.0)));
  fault_ = static_cast<Fault>(index(kFaults));
  reading_ = static_cast<Reading>(index(kReadings));
  const std::size_t size = std::max<std::size_t>(1, numbers(measurement, reading_).size());
  one_ = index(size);
  other_ = (one_ + 1 + index(std::max<std::size_t>(1, size - 1))) % size;
  // A part of an attitude that sticks alone is no rotation; forces come from two sensors.
  all_ = uniform(0.0, 1.0) < 0.5;
  size_ = (uniform(-1.0, 1.0) < 0.0 ? -1.0 : 1.0) * kSmallestSpike *
          std::pow(kLargestSpike / kSmallestSpike, uniform(0.0, 1.0));
  const Vec3 axis(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0));
  turn_ = rotation_exp(M_PI * std::pow(kSmallestSpike, uniform(0.0, 1.0)) * axis.normalized());
  before_ = measurement;
}

double Glitches::uniform(double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random_);
}

std::size_t Glitches::index(std::size_t size) {
  return std::uniform_int_distribution<std::size_t>(0, size - 1)(random_);
}

}  // namespace baton
