/// What the commands of a run asked for, and what the motions planned for them made of it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "baton/run/sink.hpp"

namespace baton {

/// Pose of the point that a command guides: a sole, a hand, or the COM with the trunk's attitude.
[[nodiscard]] Pose guided_pose(const Kinematics& kinematics, Part part);

/// A command is credited with the displacement of its part, along what was asked for, from the beginning of each motion
/// that was planned for it until that motion was to end, whatever replaces it.
class CommandAccount {
 public:
  /// The robot must outlive the object.
  explicit CommandAccount(const RobotModel& robot) : robot_(&robot) {}

  /// One tick.
  /// @param truth the robot's configuration at this tick
  void add(const TickRecord& record, const Kinematics& truth);

  /// The planner has answered a request: a motion that begins now is for the present command.
  void answered(const Request& request);

  /// {"given", "moved"}: how many commands, and how many of them moved their part.
  [[nodiscard]] nlohmann::json json() const;

 private:
  /// A maximal interval of constant input that asks for something. Vectors are in the world.
  struct Interval {
    Command command;
    Vec3 asked = Vec3::Zero();           ///< displacement of the guided part by one motion [m]
    Vec3 asked_rotation = Vec3::Zero();  ///< [rad]
    double made = 0.0;                   ///< along `asked`, by motions that are over [m]
    double made_rotation = 0.0;          ///< along `asked_rotation` [rad]
    double most = 0.0;                   ///< the largest so far [m]
    double most_rotation = 0.0;          ///< [rad]
    [[nodiscard]] bool moved() const;
  };

  /// What a motion does for the command that it was planned for.
  struct Credit {
    std::size_t command = 0;
    Pose start;          ///< of the guided part
    double until = 0.0;  ///< [s]
  };

  /// What a command asks for, if anything that its part can do.
  [[nodiscard]] std::optional<Interval> asked(const Command& command, bool lifts, const Mat3& heading) const;
  /// Where a command stands now.
  /// @param over it makes no more by this motion
  void account(const Credit& credit, const Kinematics& truth, bool over);

  const RobotModel* robot_;
  std::vector<Interval> intervals_;
  Command last_command_;
  long command_ = -1;     ///< interval that stands now; −1: nothing is asked for
  long planned_by_ = -1;  ///< interval that the last answer was for
  std::vector<Credit> open_;
};

}  // namespace baton
