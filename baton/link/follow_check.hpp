/// Whether a robot's joints go where they are told to go. Motors without power, an emergency stop at the robot or a
/// program there that answers and does nothing leave measurements that do not contradict each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton::link {

class FollowCheck {
 public:
  struct Parameters {
    double window = 0.04;  ///< time over which joints are compared with what they were told [s]
    double lasts = 0.06;   ///< time for which they must not have followed [s]
    double moves = 0.02;   ///< way that they were told to go in the window, norm over all joints, to be judged [rad]
    double share = 0.1;    ///< part of that way, in its direction, below which they do not follow
  };

  /// `robot` must outlive this object.
  explicit FollowCheck(const RobotModel& robot) : FollowCheck(robot, Parameters{}) {}
  FollowCheck(const RobotModel& robot, Parameters parameters);

  /// Takes the next tick.
  /// @param commanded where the joints were told to be when they were measured (n) [rad]
  /// @param measured where they were (n) [rad]
  void take(const VecX& commanded, const VecX& measured);

  /// Why the robot does not follow: the joint that is farthest off, and where it is; "": it does, or stands still.
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  struct Tick {
    VecX commanded, measured;  ///< (n) [rad]
  };

  const RobotModel* robot_;
  Parameters parameters_;
  std::vector<Tick> ticks_;  ///< of the window, a ring
  std::size_t taken_ = 0;
  int stuck_ = 0;  ///< ticks in a row in which they did not follow
  std::string why_;
};

}  // namespace baton::link
