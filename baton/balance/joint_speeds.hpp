/// Joint speeds without encoder noise: planned speeds plus the low-passed tracking error.
#pragma once

#include "baton/math/pose.hpp"

namespace baton {

class JointSpeeds {
 public:
  /// @param joints number of joints
  /// @param period of the measurements [s]
  JointSpeeds(int joints, double period);

  /// Smooths measured speeds in place [rad/s].
  void smooth(VecX& measured, const Eigen::Ref<const VecX>& planned);

 private:
  double gain_;  ///< fraction of a change that is followed in a tick
  VecX error_;   ///< measured − planned, low-passed [rad/s]
};

}  // namespace baton
