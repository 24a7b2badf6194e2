/// Whether the planned soles can give a contact wrench: forces at the soles' vertices, each in its friction pyramid
/// (docs/theory.md §3). On any ground this covers ZMP, friction and yaw torque in one.
#pragma once

#include <memory>

#include "baton/model/contact.hpp"
#include "baton/model/limits.hpp"

namespace baton {

class VertexForces {
 public:
  /// The model must outlive the object.
  VertexForces(const RobotModel& robot, const Limits& limits);
  ~VertexForces();

  /// From now on soles are taken smaller by these limits' `zmp_verify`, and friction as their `friction`.
  void set(const Limits& limits);

  /// Share of the weight that no such forces give, moments counted at the length of the nominal COM height: 0 if the
  /// wrench can be had. The minimiser of |G f − w|² + ε|f|² over the pyramids.
  /// @param total wrench from the ground, about the frame's origin
  /// @param com where the moments are taken [m]
  [[nodiscard]] double missing(const BySide<Pose>& sole, const BySide<bool>& contact, const Wrench& total,
                               const Vec3& com);

 private:
  struct Workspace;
  const RobotModel* robot_;
  BySide<std::vector<Vec2>> vertices_;
  double friction_ = 0.0;
  std::unique_ptr<Workspace> w_;
};

}  // namespace baton
