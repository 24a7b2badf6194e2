/// A look along a candidate motion: inverse kinematics and dynamics at a few of its postures only.
#pragma once

#include <variant>
#include <vector>

#include "baton/plan/segment.hpp"

namespace baton {

/// Share by which a torque that a survey finds may be too large: it is not exact.
inline constexpr double kRoughly = 1.05;

class Survey {
 public:
  /// The model must outlive the object.
  explicit Survey(const RobotModel& robot);

  /// What certainly speaks against a candidate, so that it is not worth being worked out; else the limbs' part in its
  /// ZMP.
  /// @param looked in: postures of the last survey of this segment, or none: where this one starts from; out: its own
  [[nodiscard]] std::variant<VrpOffset, Refusal> look(const Segment& segment, const ComPath& path, const Timing& timing,
                                                      std::vector<VecX>& looked);

 private:
  /// The postures looked at.
  struct Way {
    std::vector<double> t;   ///< [s]
    std::vector<VecX> q;     ///< (nq)
    std::vector<VecX> step;  ///< velocity between postures i − 1 and i; 0 before the first and after the last (nv)
  };
  /// Postures by inverse kinematics; a refusal if a joint or its speed is out of bounds, or a part out of reach.
  [[nodiscard]] std::optional<Refusal> follow(const Segment& segment, const ComPath& path, const Timing& timing,
                                              const std::vector<VecX>& looked, Way& way);
  /// The limbs' part in the ZMP; a refusal if a motor is too weak.
  [[nodiscard]] std::variant<VrpOffset, Refusal> load(const Segment& segment, const ComPath& path, const Timing& timing,
                                                      const Way& way);

  const RobotModel* robot_;
  InverseKinematics ik_;
  Kinematics kinematics_;
};

}  // namespace baton
