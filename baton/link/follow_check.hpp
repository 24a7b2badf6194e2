/// Whether a robot's legs go where they are told to go. An emergency stop that holds the joints, or a program there
/// that answers and does nothing, leave measurements that do not contradict each other. Arms are not asked: something
/// may be in their way.
#pragma once

#include <string>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton::link {

class FollowCheck {
 public:
  struct Parameters {
    double window = 0.04;  ///< time over which joints are compared with what they were told, or 8 ticks [s]
    double lasts = 0.06;   ///< time for which they must not have followed, or 12 ticks [s]
    double moves =
        0.02;  ///< way that they were told to go in the window, norm over the legs' joints, to be judged [rad]
    double share = 0.1;  ///< part of that way, in its direction, below which they do not follow
  };

  /// `robot` must outlive this object.
  explicit FollowCheck(const RobotModel& robot) : FollowCheck(robot, Parameters{}) {}
  FollowCheck(const RobotModel& robot, Parameters parameters);

  /// Forgets what was taken, and why it did not follow.
  void begin();
  /// Takes the next tick.
  /// @param commanded where the joints were told to be when they were measured (n) [rad]
  /// @param measured where they were (n) [rad]
  void take(const VecX& commanded, const VecX& measured);

  /// Why the robot does not follow: the joint that is farthest off, and where it is; "": it does, or stands still.
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  struct Tick {
    VecX commanded, measured;  ///< of the legs' joints [rad]
  };
  [[nodiscard]] VecX of_legs(const VecX& q) const;

  const RobotModel* robot_;
  Parameters parameters_;
  std::vector<int> joints_;  ///< of the legs
  std::vector<Tick> ticks_;  ///< of the window, a ring
  int lasts_;                ///< [ticks]
  std::size_t taken_ = 0;
  int stuck_ = 0;  ///< ticks in a row in which they did not follow
  std::string why_;
};

}  // namespace baton::link
