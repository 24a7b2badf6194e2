/// What a run writes: trace, report and model, opened before it begins so that nothing is lost after it.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "baton/record/output_file.hpp"
#include "baton/record/recording.hpp"
#include "baton/record/report.hpp"
#include "baton/record/trace.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {

/// The hand is at a place when it is as near as this [m].
inline constexpr double kReached = 0.01;

/// A file, and the option that names it.
struct NamedFile {
  std::string option;
  std::optional<std::filesystem::path> file;
};

/// To be called before anything is written.
/// @throws InputError one of `outputs` is the same file as another one or as one of `inputs`, whatever names they go by
void check_distinct(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

/// What a run reads, of files that have no option of their own among its outputs.
/// @param robot as given to `--robot`
[[nodiscard]] std::vector<NamedFile> files_read(const std::string& robot, const RobotModel& model, const World& world);

/// Makes a folder, unless it is there.
/// @throws InputError it cannot be made; the message names `option`
void make_folder(const std::filesystem::path& folder, const std::string& option);

/// Wall-clock time [s].
[[nodiscard]] double seconds_since(std::chrono::steady_clock::time_point start);

class Outputs {
 public:
  /// Observes the run from now on; it must not be stepped after the object is gone.
  /// @throws InputError a file cannot be written
  /// @throws std::runtime_error the model could not be written whole
  Outputs(Simulation& simulation, const std::optional<std::filesystem::path>& report,
          const std::optional<std::filesystem::path>& trace, const std::optional<std::filesystem::path>& model);

  /// Records the run besides, for `baton replay`.
  /// @param head what the run is of
  /// @throws InputError the file cannot be written
  void record(Session& session, const std::filesystem::path& file, const nlohmann::json& head);

  /// Writes the report, with the members of `extra` added, and closes trace and recording; returns the report.
  /// @throws std::runtime_error not all of that could be written whole: what could is
  nlohmann::json write(const std::string& world, const std::string& on, long seed, double wall,
                       const nlohmann::json& extra = nlohmann::json::object());

 private:
  Report report_;
  std::optional<OutputFile> report_file_;
  std::optional<Trace> trace_;
  std::optional<RecordingWriter> recording_;
};

}  // namespace baton::app
