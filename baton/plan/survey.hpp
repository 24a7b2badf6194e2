/// Coarse rollout of a candidate motion: inverse kinematics and dynamics at a few postures.
#pragma once

#include <variant>
#include <vector>

#include "baton/plan/segment.hpp"

namespace baton {

/// Tolerance factor on torques in a survey, which is approximate.
inline constexpr double kRoughly = 1.05;

class Survey {
 public:
  /// `robot` must outlive this object.
  explicit Survey(const RobotModel& robot);

  /// A refusal if the candidate certainly fails, to save the full computation; else the limbs' contribution to the ZMP.
  /// @param looked in: postures of this segment's last survey, for warm start, or none; out: postures of this one
  [[nodiscard]] std::variant<VrpOffset, Refusal> look(const Segment& segment, const ComPath& path, const Timing& timing,
                                                      std::vector<VecX>& looked);

 private:
  /// The sampled postures.
  struct Way {
    std::vector<double> t;   ///< [s]
    std::vector<VecX> q;     ///< (nq)
    std::vector<VecX> step;  ///< velocity between postures i − 1 and i; 0 before the first and after the last (nv)
  };
  /// Solves inverse kinematics; a refusal if a joint angle or speed is out of bounds, or a part out of reach.
  [[nodiscard]] std::optional<Refusal> follow(const Segment& segment, const ComPath& path, const Timing& timing,
                                              const std::vector<VecX>& looked, Way& way);
  /// The limbs' contribution to the ZMP; a refusal if a motor is too weak.
  [[nodiscard]] std::variant<VrpOffset, Refusal> load(const Segment& segment, const ComPath& path, const Timing& timing,
                                                      const Way& way);

  const RobotModel* robot_;
  InverseKinematics ik_;
  Kinematics kinematics_;
};

}  // namespace baton
