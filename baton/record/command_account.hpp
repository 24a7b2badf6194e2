/// Compares what commands asked for with what the motions planned for them achieved.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "baton/run/sink.hpp"

namespace baton {

/// Pose of the point that a command guides: a sole, a hand, or the COM with the trunk's attitude.
[[nodiscard]] Pose guided_pose(const Kinematics& kinematics, Part part);

/// A command is credited with the displacement of its part along the requested direction, from the start of each motion
/// planned for it to that motion's planned end, even if it is replaced.
class CommandAccount {
 public:
  /// `robot` must outlive this object.
  explicit CommandAccount(const RobotModel& robot) : robot_(&robot) {}

  /// One tick.
  /// @param truth the robot's true kinematics at this tick
  void add(const TickRecord& record, const Kinematics& truth);

  /// The planner has answered a request: a motion that starts now belongs to the current command.
  void answered(const Request& request);

  /// {"given", "moved"}: number of commands, and of those that moved their part.
  [[nodiscard]] nlohmann::json json() const;

 private:
  /// A maximal interval of constant, non-neutral input. Vectors are in the world frame.
  struct Interval {
    Command command;
    Vec3 asked = Vec3::Zero();           ///< requested displacement of the guided part per motion [m]
    Vec3 asked_rotation = Vec3::Zero();  ///< requested rotation per motion [rad]
    double made = 0.0;                   ///< along `asked`, by completed motions [m]
    double made_rotation = 0.0;          ///< along `asked_rotation` [rad]
    double most = 0.0;                   ///< largest `made` so far, with the motion under way [m]
    double most_rotation = 0.0;          ///< [rad]
    /// @param always displacement that always counts [m]
    [[nodiscard]] bool moved(double always) const;
  };

  /// An open motion and the command it was planned for.
  struct Credit {
    std::size_t command = 0;
    Pose start;          ///< pose of the guided part
    double until = 0.0;  ///< [s]
  };

  /// What a command asks for; none if its part can do nothing of it.
  [[nodiscard]] std::optional<Interval> asked(const Command& command, bool lifts, const Mat3& heading) const;
  /// Updates the displacement of a command.
  /// @param over this motion has ended
  void account(const Credit& credit, const Kinematics& truth, bool over);

  const RobotModel* robot_;
  std::vector<Interval> intervals_;
  Command last_command_;
  long command_ = -1;     ///< current interval; −1: none
  long planned_by_ = -1;  ///< interval of the last answer
  std::vector<Credit> open_;
};

}  // namespace baton
