#include "baton/calibrate/rest.hpp"

namespace baton {

void RestMean::add(const Measurement& measurement) {
  const Eigen::Index n = measurement.q.size();
  if (size_++ == 0) sum_.q = sum_.torque = VecX::Zero(n);
  sum_.q += measurement.q;
  if (measurement.torque.size() == n) sum_.torque += measurement.torque;
  sum_.acceleration += measurement.imu.acceleration;
  for (const Side side : kSides) {
    sum_.sole[side].force += measurement.sole[side].force;
    sum_.sole[side].moment += measurement.sole[side].moment;
  }
}

Rest RestMean::mean() const {
  Rest mean = sum_;
  mean.q /= size_;
  mean.torque /= size_;
  mean.acceleration /= size_;
  for (const Side side : kSides) {
    mean.sole[side].force /= size_;
    mean.sole[side].moment /= size_;
  }
  return mean;
}

}  // namespace baton
