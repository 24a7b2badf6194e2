/// A robot at the other end of a connection, as `baton drive` has it.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/robot/calibration.hpp"
#include "baton/run/session.hpp"

namespace baton::app {

/// Something that happened between the two ends.
struct LinkNote {
  double t = 0.0;    ///< of the run [s]
  std::string what;  ///< late, in_time, fault, fault_over, battery, rejected, damped or broken
  std::string text;
};

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
  /// What a simulator at the other end says of its plant, for the settings of a recording.
  [[nodiscard]] std::map<std::string, std::string> settings() const;
  /// Where a session begins: for a robot that hangs, in its stance.
  /// @param calibration what is known of the sensors' errors
  /// @throws InputError the robot does not stand on both soles
  [[nodiscard]] Posture start(const World& world, const std::optional<Calibration>& calibration);
  /// Whether that was in the stance of its profile.
  [[nodiscard]] bool starts_in_stance() const { return in_stance_; }
  /// Whether it has not come to its stance yet: the stick does not count until then.
  [[nodiscard]] bool engaging() const { return engaging_; }
  /// Where that session plans: what a robot that navigates by itself has planned, or by `planner`.
  [[nodiscard]] std::unique_ptr<Planning> planning(std::unique_ptr<Planning> planner) const;

  /// Call it once all is prepared, right before the first tick: in real time, what has been measured meanwhile is
  /// left out, and a robot that hangs takes its stance.
  /// @param go_on asked each tick; false: it is handed back as it is
  /// @throws InputError, LinkError as `link::take_stance`
  void begin(const std::optional<Calibration>& calibration, const std::function<bool()>& go_on);
  /// One tick of the session.
  /// @param stick where it is now; looked at again, if the robot goes on by its own clock and navigates by itself
  /// @returns whether the robot still follows
  [[nodiscard]] bool step(Session& session, const std::function<Command()>& stick);
  /// Drives the arms of the robot, and of the session.
  void drive_arms(Session& session, const ArmTargets& targets);
  /// Lets the robot's motors only brake; the next step finds that it follows no longer.
  void damp(const std::string& because);
  /// @param passing called about every 10 ms while the robot is waited for
  void meanwhile(std::function<void()> passing);
  /// Why it follows no longer; "": it does.
  [[nodiscard]] const std::string& broken() const { return broken_; }

  /// Lets the log, the report and who asks for notes know.
  void note(bool warning, const char* what, const std::string& text);
  /// What has happened since the last call; it has been logged.
  [[nodiscard]] std::vector<LinkNote> notes() { return std::exchange(new_notes_, {}); }
  /// For the operator while the stick does not count, because of the link or the robot; else "".
  [[nodiscard]] std::string notice() const;

  /// For the report.
  [[nodiscard]] nlohmann::json json() const;

 private:
  void look_engaged(const Session& session);
  void look_held(Session& session);
  void look_late();
  void look_fault();
  void warn();
  void end(const std::string& why);

  std::string address_;
  const RobotModel* model_;
  std::unique_ptr<link::RemoteRobot> owned_;
  link::RemoteRobot* remote_;
  bool hangs_;
  bool in_stance_ = true;
  bool engaging_ = false;
  long rested_ = 0;    ///< ticks, while engaging
  bool told_ = false;  ///< that the robot has rejected a target
  bool stale_ = false;
  bool late_ = false;  ///< the measurements of a robot that follows targets, in the last tick
  bool held_ = false;  ///< the stick of a robot that follows targets counts as centred
  std::string fault_;  ///< that has been noted
  long late_ticks_ = 0;
  bool low_ = false;       ///< its battery, which has been logged
  bool damped_ = false;    ///< that has been asked for
  bool undamped_ = false;  ///< that could not be asked for, which has been logged
  std::string broken_;
  double t_ = 0.0;               ///< of the session [s]
  std::vector<LinkNote> notes_;  ///< the first of them, for the report
  std::vector<LinkNote> new_notes_;
};

}  // namespace baton::app
