/// What a robot's sensors read on average while it rests.
#pragma once

#include "baton/balance/measurement.hpp"

namespace baton {

struct Rest {
  BySide<bool> contact{true, true};  ///< which soles stand
  int stance = 0;                    ///< the same number: no foot was moved between these rests
  VecX q;                            ///< joint angles by the encoders (n) [rad]
  VecX torque;                       ///< motor torques (n) [N·m]; 0 where they are not measured
  Vec3 acceleration = Vec3::Zero();  ///< specific force in the frame of the IMU [m/s²]
  BySide<Wrench> sole;               ///< contact wrench on each sole, in the sole frame, moment about its centre
};

/// The mean of measurements.
class RestMean {
 public:
  void add(const Measurement& measurement);
  [[nodiscard]] int size() const { return size_; }
  /// The mean of what was added, at least one measurement; contact and stance are for the caller to set.
  [[nodiscard]] Rest mean() const;

 private:
  Rest sum_;
  int size_ = 0;
};

}  // namespace baton
