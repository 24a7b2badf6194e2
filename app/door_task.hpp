/// The task in the room: the left hand at door B.
#pragma once

#include "app/outputs.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/model/world.hpp"

namespace baton::app {

/// Judges by the truth whether the hand has been held at the door.
class DoorTask {
 public:
  /// @throws InputError the world has no site `door_B`
  DoorTask(const RobotModel& robot, const World& world)
      : door_(world.site("door_B").p), period_(robot.profile().tick.period) {}

  /// Call after every tick.
  /// @param robot at the true configuration
  void look(const Kinematics& robot) {
    error_ = (robot.hand(Side::left).p - door_).norm();
    held_ = error_ < kReached ? held_ + period_ : 0.0;
    reached_ = reached_ || held_ >= kHeld;
  }

  /// Distance of the hand from the door [m].
  [[nodiscard]] double error() const { return error_; }
  /// Whether the hand has been within `kReached` for `kHeld`.
  [[nodiscard]] bool reached() const { return reached_; }

 private:
  Vec3 door_;
  double period_;
  double error_ = 0.0;
  double held_ = 0.0;  ///< time that the hand has been there [s]
  bool reached_ = false;
};

}  // namespace baton::app
