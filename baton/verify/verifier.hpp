/// Candidate motion → verified motion or refusal: every limit, on the whole-body model, at every tick.
#pragma once

#include <limits>
#include <variant>

#include "baton/model/contact.hpp"
#include "baton/model/limits.hpp"
#include "baton/model/world.hpp"
#include "baton/verify/obstacles.hpp"
#include "baton/verify/verified_motion.hpp"
#include "baton/verify/vertex_forces.hpp"

namespace baton {

class Verifier {
 public:
  /// Robot and world must outlive the object.
  Verifier(const RobotModel& robot, const World& world);

  /// Checks joint positions, speeds, accelerations and torques (one Motor model), what inverse kinematics left between
  /// posture and plan, how far the trunk leans, the contact wrench of the whole body (ZMP, friction, forces at the
  /// soles' vertices), the gap of the soles, the swing sole over the ground and the footholds, all at every tick;
  /// self-collision and obstacles wherever links have moved far enough to change the least distance. Ends at a
  /// violation. Completes the samples on the way: force, ZMP and where
  /// that may be commanded.
  /// @param motion samples with q, dq, ddq, soles and contacts
  /// @param anchor planning frame in the world
  [[nodiscard]] std::variant<VerifiedMotion, Refusal> verify(Motion motion, const Pose& anchor, const Limits& limits);

 private:
  class Ledger;

  /// @param jump factor by which accelerations count
  void check_joints(const MotionSample& sample, double jump, double t, Ledger& ledger) const;
  void check_wrench(Motion& motion, int tick, double t, Ledger& ledger);
  void check_tracking(const MotionSample& sample, double t, Ledger& ledger);
  void check_footholds(const Motion& motion, const Pose& anchor, Ledger& ledger) const;
  void check_distances(const MotionSample& sample, const Pose& anchor, bool first, double t, Ledger& ledger);
  /// How far any point of a link may have moved since the last call [m]: a bound from above.
  [[nodiscard]] double travel();
  void check_soles(const Motion& motion, std::size_t tick, const Pose& anchor, Ledger& ledger) const;
  /// How high a foot that is to land must be over the ground there [m]: enough not to scrape, however it follows.
  [[nodiscard]] double clearance(const Motion& motion, std::size_t tick) const;
  /// How far the trunk may lean on its way [rad].
  [[nodiscard]] double most_lean(const Motion& motion);
  /// How far from edges soles are to be kept [m].
  [[nodiscard]] double edge_margin(const Motion& motion) const;
  /// How far the swing foot stays from higher ground beside it: as far as it should land, or as it stands, after a
  /// slip: else it could not leave.
  [[nodiscard]] double swing_margin(const Motion& motion, const Pose& anchor) const;
  /// The least height above the ground of a foot that leaves it, or meets it [m].
  [[nodiscard]] double lowest(const Motion& motion, const Pose& anchor) const;

  const RobotModel* robot_;
  const World* world_;
  Kinematics kinematics_;
  VertexForces forces_;
  Obstacles obstacles_;
  VecX tau_;
  /// What the motion under verification is held to.
  struct Bounds {
    Limits limits;
    double swing_margin = 0.0;  ///< [m]
    double lowest = 0.0;        ///< [m]
    double lean = 0.0;          ///< the largest tilt of the trunk [rad]
  };
  Bounds bounds_;
  ConvexPolygon support_;  ///< of the soles that stand
  VecX in_world_;

  /// What is known of a distance between two measurements of it.
  struct Gap {
    double room = 0.0;                                       ///< it is no less than this [m]
    double least = std::numeric_limits<double>::infinity();  ///< so far [m]
    double limit = 0.0;                                      ///< it must not be less than this [m]
  };
  Gap self_gap_;
  Gap world_gap_;
  std::vector<Pose> links_;     ///< of all bodies but the world, when last seen
  std::vector<double> extent_;  ///< of their geoms about the body's origin [m]
};

}  // namespace baton
