/// Joint speeds without the noise of encoders: the planned ones, and the smoothed error of the measured ones from them.
#pragma once

#include "baton/math/pose.hpp"

namespace baton {

class JointSpeeds {
 public:
  /// @param joints their number
  /// @param period of the measurements [s]
  JointSpeeds(int joints, double period);

  /// Smooths measured speeds in place [rad/s].
  void smooth(VecX& measured, const Eigen::Ref<const VecX>& planned);

 private:
  double share_;  ///< of a change that is followed in a tick
  VecX error_;    ///< measured − planned, smoothed [rad/s]
};

}  // namespace baton
