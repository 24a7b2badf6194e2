/// Candidate motion → verified motion or refusal: checks all limits on the whole-body model at every tick.
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

  /// Checks at every tick: joint positions, speeds, accelerations, torques and heat; residuals of inverse kinematics;
  /// trunk inclination; the whole-body contact wrench (ZMP, friction, forces at the soles' vertices); the gap between
  /// the soles; and the clearance of the swing sole. Checks the foothold at every touchdown. Distances from
  /// self-collision and obstacles are measured again once the links have moved far enough to lower their minimum. The
  /// checks of joints and swing run at every tick, since the worst value tells how much to stretch the motion; the
  /// costlier ones stop at the first violation.
  ///
  /// Fills in the samples' `force`, `zmp`, `zmp_height` and `zmp_region`, the heat at the `end`, and `held`.
  /// A motor that is hotter than allowed to begin with may get a little hotter.
  /// @param motion samples with q, dq, ddq, COM, soles and contacts; `end` and `rest` in the posture of the last one
  /// @param anchor planning frame in the world
  /// @throws std::invalid_argument the motion would rest in another posture than that of its last sample
  [[nodiscard]] std::variant<VerifiedMotion, Refusal> verify(Motion motion, const Pose& anchor, const Limits& limits);

 private:
  class Ledger;

  /// @param jump factor on the joint accelerations
  void check_joints(const MotionSample& sample, double jump, double t, Ledger& ledger) const;
  void check_wrench(Motion& motion, int tick, double t, Ledger& ledger);
  /// Advances the motors' heat by the torques of this tick, `tau_`.
  void check_heat(const Motion& motion, double t, Ledger& ledger);
  /// What the motors come to in the posture of the last sample.
  [[nodiscard]] Hottest held(const MotionSample& last);
  void check_tracking(const MotionSample& sample, double t, Ledger& ledger);
  void check_footholds(const Motion& motion, const Pose& anchor, Ledger& ledger) const;
  void check_distances(const MotionSample& sample, const Pose& anchor, bool first, double t, Ledger& ledger);
  /// Upper bound on the displacement of any point of any link since the last call [m].
  [[nodiscard]] double travel();
  void check_soles(const Motion& motion, std::size_t tick, const Pose& anchor, Ledger& ledger) const;
  /// Height required above `least_height` at a tick, so that a foot that lags behind its plan does not scrape [m].
  [[nodiscard]] double clearance(const Motion& motion, std::size_t tick) const;
  /// Limit of the trunk's tilt [rad].
  [[nodiscard]] double max_tilt(const Motion& motion);
  /// Required distance of footholds from terrain edges [m].
  [[nodiscard]] double edge_margin(const Motion& motion) const;
  /// Least height of a swing sole above the terrain at lift-off and touchdown [m]: negative, by the tolerance of
  /// inverse kinematics.
  [[nodiscard]] double contact_height() const;
  /// Horizontal distance that the swing foot keeps from higher terrain [m]: the edge margin, or less if the foot stands
  /// closer than that after a slip, as it could not lift off otherwise.
  [[nodiscard]] double swing_margin(const Motion& motion, const Pose& anchor) const;
  /// Least height of the swing foot above the terrain, at lift-off and touchdown [m].
  [[nodiscard]] double least_height(const Motion& motion, const Pose& anchor) const;

  const RobotModel* robot_;
  const World* world_;
  Kinematics kinematics_;
  VertexForces forces_;
  Obstacles obstacles_;
  VecX tau_;
  HeatModel heat_model_;
  Heat heat_;  ///< at the current tick
  /// Limits of the motion under verification.
  struct Bounds {
    Limits limits;
    double swing_margin = 0.0;  ///< [m]
    double least_height = 0.0;  ///< [m]
    double tilt = 0.0;          ///< of the trunk [rad]
    double uncertainty = 0.0;   ///< of the place, beside obstacles [m]
  };
  Bounds bounds_;
  ConvexPolygon support_;  ///< support polygon of the current tick
  VecX in_world_;          ///< configuration in the world (nq)

  /// A distance that is not measured at every tick.
  struct Gap {
    double lower_bound = 0.0;                                   ///< lower bound on the current distance [m]
    double smallest = std::numeric_limits<double>::infinity();  ///< smallest measured so far [m]
    double limit = 0.0;                                         ///< smallest allowed [m]
  };
  Gap self_gap_;
  Gap world_gap_;
  Gap map_gap_;                 ///< the same where the uncertainty of the place counts, less that
  std::vector<Pose> links_;     ///< poses of all bodies but the world, at the last call of `travel`
  std::vector<double> extent_;  ///< largest distance of their geoms' points from the body's origin [m]
};

}  // namespace baton
