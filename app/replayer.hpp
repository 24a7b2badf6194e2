/// Lives through a recorded run again, with a navigator and a planner of its own.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "baton/plan/strategy.hpp"
#include "baton/record/recording.hpp"

namespace baton::app {

class Replayer {
 public:
  /// @param verify compare what the navigator does with what is recorded
  /// @throws InputError the file is no recording, or its robot or world cannot be loaded
  Replayer(const std::filesystem::path& recording, bool verify);

  /// Replays the next tick. @returns false at the end, or before a gap
  /// @throws InputError the recording is damaged, or of another robot
  bool step();

  /// In what the last tick differs from the recorded one; "": in nothing.
  [[nodiscard]] const std::string& difference() const { return difference_; }
  /// Ticks that the recording lacks after the last one.
  [[nodiscard]] long gap() const { return gap_; }
  [[nodiscard]] const Navigator& navigator() const { return *navigator_; }
  [[nodiscard]] const RobotModel& robot() const { return robot_; }
  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const RecordingReader& recording() const { return recording_; }
  /// The last tick, and its joint target.
  [[nodiscard]] const RecordedTick& tick() const { return *tick_; }
  [[nodiscard]] const JointTarget& target() const { return *target_; }

 private:
  void compare();
  /// Passes requests and answers between navigator and planner as in the run.
  void plan();

  RecordingReader recording_;
  bool verify_;
  RobotModel robot_;
  World world_;
  std::vector<std::string> joints_;
  std::optional<Navigator> navigator_;
  Strategy strategy_;
  std::optional<RecordedTick> tick_;
  const JointTarget* target_ = nullptr;
  std::optional<Answer> answer_;
  std::string difference_;
  long gap_ = 0;
};

}  // namespace baton::app
