/// Output files of a run: trace, report, model, recording. Opened before the run, so that errors show at once.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "baton/plan/modes.hpp"
#include "baton/record/output_file.hpp"
#include "baton/record/recording.hpp"
#include "baton/record/report.hpp"
#include "baton/record/trace.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {

/// Position tolerance of a reached hand target [m].
inline constexpr double kReached = 0.01;
/// Time for which the hand has to be there [s].
inline constexpr double kHeld = 1.0;

/// A file, and the option that names it.
struct NamedFile {
  std::string option;
  std::optional<std::filesystem::path> file;
};

/// Call before anything is written.
/// @throws InputError an output is the same file as another output or an input, under whatever name
void check_distinct(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

/// Input files of robot and world, for `check_distinct`.
/// @param robot as given to `--robot`
[[nodiscard]] std::vector<NamedFile> files_read(const std::string& robot, const RobotModel& model, const World& world);

/// Creates a folder if it does not exist.
/// @throws InputError it cannot be created; the message names `option`
void make_folder(const std::filesystem::path& folder, const std::string& option);

/// Elapsed wall-clock time [s].
[[nodiscard]] double seconds_since(std::chrono::steady_clock::time_point start);

/// The robot's profile with all that is derived, as TOML.
/// @param robot as given to `--robot`
/// @param model to be named in it; else it is as in the robot's profile, relative to that
/// @throws InputError a file cannot be read, or is none of a robot
[[nodiscard]] std::string whole_profile(const std::string& robot,
                                        const std::optional<std::filesystem::path>& model = std::nullopt);

/// What a run depends on beyond its settings.
struct Origins {
  nlohmann::json sums;  ///< versions of programs, checksums of files; for the settings of a recording
  std::string profile;  ///< of the robot, with all that is derived, as TOML
};

/// @param robot as given to `--robot`
/// @throws InputError a file cannot be read any more
[[nodiscard]] Origins origins_of(const std::string& robot, const RobotModel& model, const World& world);

/// The settings of a run that every recording has. Which robot it was `on` is to be added.
/// @param robot, world as given to `--robot` and `--world`
[[nodiscard]] nlohmann::json recording_head(const std::string& robot, const std::string& world, long seed, Modes modes,
                                            StateSource state, const RobotModel& model);

/// A recording of a session, for it to have as a sink. Warns once when it cannot be complete.
/// @param head robot, world and modes of the run; the sums of `origins` are added
/// @param live the run is in real time
/// @param pushes that the robot will get
/// @throws InputError the file cannot be opened
[[nodiscard]] std::unique_ptr<RecordingWriter> recording_of(const Session& session, const std::filesystem::path& file,
                                                            nlohmann::json head, const Origins& origins, bool live,
                                                            const std::vector<Push>& pushes);

class Outputs {
 public:
  /// Observes the run from now on; do not step it after this object is destroyed.
  /// @throws InputError a file cannot be written
  /// @throws std::runtime_error the model was not written completely
  Outputs(Simulation& simulation, const std::optional<std::filesystem::path>& report,
          const std::optional<std::filesystem::path>& trace, const std::optional<std::filesystem::path>& model);

  /// Also records the run, for `baton replay`: `recording_of`.
  void record(Session& session, const std::filesystem::path& file, nlohmann::json head, bool live,
              const std::vector<Push>& pushes);

  /// Records something that happened outside the navigator, between the ends of a connection.
  void note(const std::string& what, const std::string& text) {
    if (recording_) recording_->note(what, text);
  }

  /// Closes the recording, writes the report with the members of `extra` and what became of the recording added,
  /// closes the trace, and returns the report.
  /// @throws std::runtime_error a file was not written completely; the others are
  nlohmann::json write(const std::string& world, const std::string& on, long seed, double wall,
                       const nlohmann::json& extra = nlohmann::json::object());

 private:
  Report report_;
  std::optional<OutputFile> report_file_;
  std::optional<Trace> trace_;
  std::unique_ptr<RecordingWriter> recording_;
};

}  // namespace baton::app
