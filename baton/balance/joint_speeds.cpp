#include "baton/balance/joint_speeds.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kSmooth = 40.0;  ///< rate at which the smoothed error follows the measured one: by the encoders'
                                  ///< noise, not by the robot's size [1/s]

}  // namespace

JointSpeeds::JointSpeeds(int joints, double period)
    : share_(std::min(1.0, period * kSmooth)), error_(VecX::Zero(joints)) {}

void JointSpeeds::smooth(VecX& measured, const Eigen::Ref<const VecX>& planned) {
  error_ += share_ * (measured - planned - error_);
  measured = planned + error_;
}

}  // namespace baton
