/// Contact-wrench cone of the planned soles: the wrenches that forces at the soles' vertices, each in its friction
/// pyramid, can give (docs/theory.md §4). It covers ZMP, friction and yaw torque, on terrain of any shape.
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

  /// Sets the inset of the soles (`zmp_verify`) and the friction coefficient (`friction`).
  void set(const Limits& limits);

  /// Distance of a wrench from the cone as a share of the weight, 0 inside it: the residual |G f − w| of the f in the
  /// pyramids that minimises |G f − w|² + ε|f|². Moments are divided by the nominal COM height.
  /// @param total contact wrench, moment about the origin
  /// @param com reference point of the moments [m]
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
