/// Judges targets before a robot follows them.
#pragma once

#include <optional>
#include <string>

#include "baton/link/message.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::link {

/// A target is followed if it is finite, inside the joints' ranges, within what the motors can do, and near the one
/// before, or near where the joint is: so a driver may go on from either, but never make a joint jump.
class TargetCheck {
 public:
  /// `robot` must outlive this object.
  explicit TargetCheck(const RobotModel& robot) : robot_(&robot) {}

  /// Forgets the target before.
  /// @param q where the joints are (n) [rad]
  void begin(const VecX& q) { last_ = q; }

  /// @param target with vectors of the joints' number
  /// @param q where the joints are (n) [rad]
  /// @returns why the target is not followed: joint, value, limit; none: it is, and is the one before from now on
  [[nodiscard]] std::optional<std::string> reject(const Target& target, const VecX& q);

 private:
  const RobotModel* robot_;
  VecX last_;  ///< angles of the target before (n) [rad]
};

}  // namespace baton::link
