/// Total contact wrench → the wrench of each sole, as the soles can give it (docs/balance.md).
#pragma once

#include "baton/model/contact.hpp"

namespace baton {

class WrenchDistribution {
 public:
  /// L of a sole that can give the wrench w: L w ≥ 0, in its own frame, force first.
  using Limits = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

  /// The robot must outlive the object.
  explicit WrenchDistribution(const RobotModel& robot);

  /// Of all that `total` can be shared into, so that each sole's centre of pressure is `margin.zmp_feedback` inside it,
  /// its force in the friction pyramid and its twist within friction's, what is nearest to `share_wrench`: that
  /// itself where it will do. What cannot be had in full is missed by as little as can be (a small quadratic program,
  /// solved by Hildreth's method: no memory is asked for).
  /// @param sole poses in the frame of `total`
  /// @return wrenches about the origin
  [[nodiscard]] BySide<Wrench> share(const BySide<Pose>& sole, const BySide<bool>& contact, const Wrench& total);

 private:
  /// The least x with A x + b ≥ 0, as far as that can be.
  [[nodiscard]] Vec6 nearest();

  const RobotModel* robot_;
  double lever_;  ///< half the width of the stance: what a force counts by [m]
  BySide<Limits> limits_;
  Limits A_;
  VecX b_;
  VecX multiplier_;
};

}  // namespace baton
