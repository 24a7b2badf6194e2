/// Recordings of runs (docs/recording.md): all inputs of the navigator, tick by tick, and a checksum of its outputs, so
/// that a replay must reproduce the run bit for bit.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "baton/run/sink.hpp"

namespace baton {

/// Checksum over all bits of a joint target.
[[nodiscard]] std::string checksum(const JointTarget& target);

/// Which sensors' health has changed in a tick, and to what, in words.
using HealthChanges = std::map<std::string, std::string>;
[[nodiscard]] HealthChanges health_changes(std::span<const Event> events);

class RecordingWriter : public Sink {
 public:
  /// @param head robot, world and modes of the run
  /// @throws InputError the file cannot be written
  RecordingWriter(const std::filesystem::path& file, const nlohmann::json& head);

  void on_tick(const TickRecord& record) override;
  void on_planning(PlanningEvent event) override;

  /// Writes buffered data and closes the file.
  /// @throws std::runtime_error the recording was not written completely
  void close();

 private:
  void flush();

  std::filesystem::path file_;
  std::ofstream out_;
  std::string tick_;    ///< unfinished line of the last tick
  std::string events_;  ///< since then
  Command command_;
  bool first_ = true;
};

/// One tick of a recording.
struct RecordedTick {
  Measurement measurement;
  Command command;
  bool fallen = false;                ///< the robot had fallen
  HealthChanges sensors;              ///< in this tick
  std::vector<PlanningEvent> events;  ///< after the tick, in order
  VecX target;                        ///< joint angles commanded by the navigator [rad]
  std::string checksum;               ///< of the whole joint target
};

/// Settings of a recorded run, as command-line option values.
struct RecordingHead {
  std::string robot;
  std::string world;
  std::string duration;
  std::string gait;
  std::string on_limit;
  std::string state;
  std::string drive;
  std::vector<double> start;  ///< configuration (nq) in which the run began; empty: the stance, at the world's start
};

class RecordingReader {
 public:
  /// @throws InputError the file cannot be read or is not a recording
  explicit RecordingReader(const std::filesystem::path& file);

  [[nodiscard]] const RecordingHead& head() const { return head_; }

  /// The next tick; none at the end. A truncated last line is skipped.
  /// @param joints number of the robot's joints
  /// @throws InputError a line is not a tick of such a robot, or the recording has no ticks
  [[nodiscard]] std::optional<RecordedTick> next(Eigen::Index joints);

  /// File and line, as a prefix for messages.
  [[nodiscard]] std::string place() const;

 private:
  /// Reads the next line; false at the end.
  bool read_line(std::string& line);

  std::filesystem::path file_;
  std::ifstream in_;
  RecordingHead head_;
  Command command_;
  long line_ = 0;
  bool whole_ = true;  ///< the last line was terminated
};

}  // namespace baton
