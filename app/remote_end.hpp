/// A robot at the other end of a connection, as `baton drive` has it.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/commands.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/robot/calibration.hpp"
#include "baton/run/session.hpp"

namespace baton::app {

class RemoteEnd {
 public:
  /// Connects, and takes the robot over. `robot` must outlive this object.
  /// @throws InputError options that only the robot's own end has; it is another robot, stands elsewhere, or does not
  /// measure what the state is estimated from
  /// @throws LinkError nobody there, or refused
  RemoteEnd(const DriveOptions& options, const RobotModel& robot, const World& world);

  /// The robot itself, once, for a session; it stays known here.
  [[nodiscard]] std::unique_ptr<Robot> robot() { return std::move(owned_); }
  [[nodiscard]] const link::Welcome& welcome() const { return remote_->welcome(); }
  /// Where a session begins. A robot that hangs takes its stance first.
  /// @param calibration what is known of the sensors' errors
  /// @throws InputError the robot does not stand on both soles
  [[nodiscard]] Posture start(const World& world, const std::optional<Calibration>& calibration);
  /// Whether that was in the stance of its profile.
  [[nodiscard]] bool starts_in_stance() const { return in_stance_; }
  /// What counts in place of the stick, until the robot stands in its stance.
  [[nodiscard]] std::optional<Command> engaging() const;
  /// Where that session plans: what a robot that navigates by itself has planned, or by `planner`.
  [[nodiscard]] std::unique_ptr<Planning> planning(std::unique_ptr<Planning> planner) const;

  /// In real time, what has been measured while a run was prepared.
  void catch_up();
  /// One tick of the session.
  /// @returns whether the robot still follows
  [[nodiscard]] bool step(Session& session, const Command& command);
  /// Drives the arms of the robot, and of the session.
  void drive_arms(Session& session, const ArmTargets& targets);
  /// Lets the robot's motors only brake; the next step finds that it follows no longer.
  void damp(const std::string& because);
  /// Why it follows no longer; "": it does.
  [[nodiscard]] const std::string& broken() const { return broken_; }

  /// For the report.
  [[nodiscard]] nlohmann::json json() const;

 private:
  /// What is between a robot and its stance.
  enum class Engaging { nothing, way_home, gantry };

  void look_engaged(const Session& session);
  void look_stood(const Session& session);
  void warn();

  std::string address_;
  const RobotModel* model_;
  std::unique_ptr<link::RemoteRobot> owned_;
  link::RemoteRobot* remote_;
  bool hangs_;
  bool in_stance_ = true;
  Engaging engaging_ = Engaging::nothing;
  Guard guard_ = Guard::lifted;  ///< before this tick, while it is lowered
  long rested_ = 0;              ///< ticks, while engaging
  bool told_ = false;            ///< that the robot has rejected a target
  bool stale_ = false;
  bool low_ = false;     ///< its battery, which has been logged
  bool damped_ = false;  ///< that has been asked for
  std::string broken_;
};

}  // namespace baton::app
