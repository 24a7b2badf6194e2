/// Contact wrenches of the soles: the feasible ones closest to what balance asks for (docs/balance.md).
#pragma once

#include <memory>

#include "baton/model/contact.hpp"

namespace baton {

class WrenchDistribution {
 public:
  /// Contact-wrench cone of a sole: L w ≥ 0 for a wrench w = (force, moment) in the sole frame.
  using ConeRows = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

  /// The robot must outlive the object.
  explicit WrenchDistribution(const RobotModel& robot);
  ~WrenchDistribution();
  WrenchDistribution(WrenchDistribution&&) noexcept;
  WrenchDistribution& operator=(WrenchDistribution&&) noexcept;

  /// The wrenches closest to `share_wrench` of `total` that soles and motors can give: each centre of pressure inside
  /// its sole's outline inset by half of `margin.zmp_feedback`, each force in the friction pyramid, each yaw moment
  /// within torsional friction, the torques of the standing legs within the stall torques. What gives way: first the
  /// share of each sole, then the moment about the COM, then the horizontal force at the COM; never the vertical
  /// force. The largest violation is minimised if nothing is feasible. Solves a small quadratic program, without
  /// allocating memory.
  /// @param kinematics set to the configuration
  /// @param sole poses, in the frame of `kinematics` and `total`
  /// @param unloaded joint torques without contact (n) [N·m]
  /// @return wrenches about the origin; zero without contact
  [[nodiscard]] BySide<Wrench> share(const Kinematics& kinematics, const BySide<Pose>& sole,
                                     const BySide<bool>& contact, const Wrench& total, const VecX& unloaded);

 private:
  struct Program;

  /// Sets what is left of each limit, negative if exceeded. Returns the least.
  double compare(const Kinematics& kinematics, const BySide<Pose>& sole, const BySide<bool>& contact,
                 const BySide<Wrench>& shared, const VecX& unloaded);

  const RobotModel* robot_;
  double lever_;  ///< weight of forces against moments between the soles: half the stance width [m]
  BySide<ConeRows> limits_;
  std::unique_ptr<Program> program_;
};

}  // namespace baton
