/// Distribution of the contact wrench: total → each sole, within what the soles can give (docs/balance.md).
#pragma once

#include "baton/model/contact.hpp"

namespace baton {

class WrenchDistribution {
 public:
  /// Contact-wrench cone of a sole: L w ≥ 0 for a wrench w = (force, moment) in the sole frame.
  using ConeRows = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

  /// The robot must outlive the object.
  explicit WrenchDistribution(const RobotModel& robot);

  /// The distribution closest to `share_wrench` that is feasible for each sole: centre of pressure inside its outline
  /// inset by half of `margin.zmp_feedback`, force in the friction pyramid, yaw moment within torsional friction.
  /// Violations are minimised if none is feasible. Solves a small quadratic program by Hildreth's method, without
  /// allocating memory.
  /// @param sole poses in the frame of `total`
  /// @return wrenches about the origin
  [[nodiscard]] BySide<Wrench> share(const BySide<Pose>& sole, const BySide<bool>& contact, const Wrench& total);

 private:
  /// The smallest x with A x + b ≥ 0, by penalty where that is infeasible.
  [[nodiscard]] Vec6 smallest_shift();

  const RobotModel* robot_;
  double lever_;  ///< weight of forces against moments: half the stance width [m]
  BySide<ConeRows> limits_;
  ConeRows A_;
  VecX b_;
  VecX multiplier_;  ///< Lagrange multipliers of the rows of A
};

}  // namespace baton
