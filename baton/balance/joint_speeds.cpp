#include "baton/balance/joint_speeds.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kLowPass = 40.0;  ///< by the encoders' noise, so the same for robots of any size [1/s]

}  // namespace

JointSpeeds::JointSpeeds(int joints, double period)
    : gain_(std::min(1.0, period * kLowPass)), error_(VecX::Zero(joints)) {}

void JointSpeeds::smooth(VecX& measured, const Eigen::Ref<const VecX>& planned) {
  error_ += gain_ * (measured - planned - error_);
  measured = planned + error_;
}

}  // namespace baton
