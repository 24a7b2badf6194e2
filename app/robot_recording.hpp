/// Recordings of what a robot's end does: a file for each run of its navigator, whoever drives.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "app/commands.hpp"
#include "baton/link/onboard.hpp"
#include "baton/record/recording.hpp"

namespace baton::app {

class RobotRecording : private Sink {
 public:
  /// @param folder for 001.mcap, 002.mcap, …; goes on after the last one that is there
  /// @throws InputError it cannot be created
  RobotRecording(const RobotOptions& options, std::filesystem::path folder);

  /// A driver has started a navigator: a new file begins. If it cannot be written, that is logged, and the run goes on.
  /// @param on sim, ideal or real
  void begin(link::Onboard& onboard, const link::NavigationOptions& navigation, const std::string& on);
  /// Finishes the file.
  void end();
  /// A line of the log.
  void log(const std::string& text);

 private:
  void on_tick(const TickRecord& record) override;
  void on_plan(const PlanRecord& record) override;
  void on_planning(PlanningEvent event) override;
  void on_arms(const ArmTargets& targets) override;

  RobotOptions options_;
  std::filesystem::path folder_;
  int number_ = 0;
  std::unique_ptr<RecordingWriter> writer_;  ///< null between two runs
};

}  // namespace baton::app
