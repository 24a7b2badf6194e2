/// What a run writes: trace, report and model, opened before it begins so that nothing is lost after it.
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/session.hpp"
#include "baton/record/report.hpp"
#include "baton/record/trace.hpp"

namespace baton::app {

/// The hand is at a place when it is as near as this [m].
inline constexpr double kReached = 0.01;

/// Opens a file to be written.
/// @throws InputError it cannot be; the message names `option`
[[nodiscard]] std::optional<std::ofstream> open_output(const std::optional<std::filesystem::path>& file,
                                                       const std::string& option);

/// Makes a folder, unless it is there.
/// @throws InputError it cannot be made; the message names `option`
void make_folder(const std::filesystem::path& folder, const std::string& option);

/// A command as a line of a stick script that gives the very same command; infinities become large numbers, which count
/// alike.
[[nodiscard]] std::string script_line(double t, const Command& command);

class Outputs {
 public:
  /// Records `session` from now on.
  /// @throws InputError a file cannot be written
  Outputs(const RobotModel& robot, Session& session, const std::optional<std::filesystem::path>& report,
          const std::optional<std::filesystem::path>& trace, const std::optional<std::filesystem::path>& model);

  /// Records the run besides, for `baton replay`.
  /// @param head what the run is of
  /// @throws InputError the file cannot be written
  void record(Session& session, const std::filesystem::path& file, const nlohmann::json& head);

  /// Writes the report, with the members of `extra` added, and closes the trace; returns the report.
  /// @throws std::runtime_error something could not be written whole
  nlohmann::json write(const std::string& world, const std::string& on, long seed, double wall,
                       const nlohmann::json& extra = nlohmann::json::object());

 private:
  Report report_;
  std::optional<std::ofstream> report_file_;
  std::optional<Trace> trace_;
  std::optional<RecordingWriter> recording_;
};

}  // namespace baton::app
