/// Coarse rollout of a candidate motion: inverse kinematics and dynamics at a few postures.
#pragma once

#include <variant>
#include <vector>

#include "baton/plan/segment.hpp"

namespace baton {

/// Factor on the torque limit in a survey, which is approximate.
inline constexpr double kTorqueTolerance = 1.05;

class Survey {
 public:
  /// `robot` must outlive this object.
  explicit Survey(const RobotModel& robot);

  /// A refusal if the candidate certainly fails, to save the full computation; else the limbs' contribution to the ZMP.
  /// @param warm_start in: postures of this segment's last survey, or none; out: postures of this one
  [[nodiscard]] std::variant<VrpOffset, Refusal> evaluate(const Segment& segment, const ComPath& path,
                                                          const Timing& timing, std::vector<VecX>& warm_start);

 private:
  /// The sampled postures.
  struct Rollout {
    std::vector<double> t;   ///< [s]
    std::vector<VecX> q;     ///< (nq)
    std::vector<VecX> step;  ///< velocity between postures i − 1 and i; 0 before the first and after the last (nv)
  };
  /// Solves inverse kinematics; a refusal if a joint angle or speed is out of bounds, or a part out of reach.
  [[nodiscard]] std::optional<Refusal> follow(const Segment& segment, const ComPath& path, const Timing& timing,
                                              const std::vector<VecX>& warm_start, Rollout& rollout);
  /// The limbs' contribution to the ZMP; a refusal if a motor is too weak.
  [[nodiscard]] std::variant<VrpOffset, Refusal> check_dynamics(const Segment& segment, const ComPath& path,
                                                                const Timing& timing, const Rollout& rollout);

  const RobotModel* robot_;
  InverseKinematics ik_;
  Kinematics kinematics_;
};

}  // namespace baton
