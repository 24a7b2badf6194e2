/// Recordings of what a robot's end does: a file for each run of its navigator, whoever drives.
#pragma once

#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/outputs.hpp"
#include "baton/link/onboard.hpp"
#include "baton/record/recording.hpp"

namespace baton::app {

class RobotRecording : private Sink {
 public:
  /// @param folder for 001.mcap, 002.mcap, …; files that are there stay
  /// @param settings of the robot: `on`, and plant and scenario of a simulated one
  /// @throws InputError it cannot be created
  RobotRecording(const RobotOptions& options, const RobotModel& model, const World& world, std::filesystem::path folder,
                 std::map<std::string, std::string> settings);

  /// A driver has started a navigator: a new file begins. If it cannot be written, that is logged, and the run goes on.
  void begin(link::Onboard& onboard, const link::NavigationOptions& navigation);
  /// Finishes the file, meanwhile: nobody waits for the disk.
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
  std::map<std::string, std::string> settings_;
  Origins origins_;
  std::unique_ptr<RecordingWriter> writer_;  ///< null between two runs
  std::vector<std::future<void>> closing_;   ///< files that are being finished
};

}  // namespace baton::app
