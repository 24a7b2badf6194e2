/// Candidate motion → certificate or refusal: every limit, on the whole-body model, at every tick.
#pragma once

#include <variant>

#include "baton/model/contact.hpp"
#include "baton/model/world.hpp"
#include "baton/motion/motion.hpp"
#include "baton/verify/obstacles.hpp"

namespace baton {

class Verifier {
 public:
  /// Robot and world must outlive the object.
  Verifier(const RobotModel& robot, const World& world);

  /// Checks joint positions, speeds and torques (one Motor model), the ZMP and friction of the whole body, the
  /// gap of the soles, the swing sole over the ground, self-collision and obstacles, tick by tick, and stops at the
  /// first violation. Fills in `force`, `zmp` and `zmp_height` of the samples on the way.
  /// @param motion samples with q, dq, ddq, soles and contacts
  /// @param anchor planning frame in the world
  [[nodiscard]] std::variant<Certificate, Refusal> verify(Motion& motion, const Pose& anchor);

 private:
  class Ledger;

  void check_joints(const MotionSample& sample, double t, Ledger& ledger) const;
  void check_wrench(const Motion& motion, int tick, double t, Ledger& ledger);
  void check_distances(const MotionSample& sample, const Pose& anchor, double t, Ledger& ledger);
  void check_soles(const MotionSample& sample, const Pose& anchor, double t, Ledger& ledger) const;

  const RobotModel* robot_;
  const World* world_;
  Kinematics kinematics_;
  Obstacles obstacles_;
  VecX tau_;
  VecX in_world_;
};

}  // namespace baton
