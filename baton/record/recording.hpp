/// A run as it happened: everything that the navigator was given, tick by tick, and a checksum of what it answered, so
/// that the run can be lived through again and must come out the same bit by bit (docs/recording.md).
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "baton/run/sink.hpp"

namespace baton {

/// Checksum of a joint target, every bit of it.
[[nodiscard]] std::string checksum(const JointTarget& target);

class RecordingWriter : public Sink {
 public:
  /// @param head what the run is of: robot, world, modes
  /// @throws InputError the file cannot be written
  RecordingWriter(const std::filesystem::path& file, const nlohmann::json& head);

  void on_tick(const TickRecord& record) override;
  void on_planning(PlanningEvent event) override;

  /// Writes what is left.
  /// @throws std::runtime_error the recording could not be written whole
  void close();

 private:
  void flush();

  std::filesystem::path file_;
  std::ofstream out_;
  std::string tick_;    ///< line of the last tick, not yet closed
  std::string events_;  ///< since then
  Command command_;
  bool first_ = true;
};

/// One tick of a recording.
struct RecordedTick {
  Measurement measurement;
  Command command;
  bool fallen = false;                ///< the robot was seen to have fallen
  std::vector<PlanningEvent> events;  ///< after the tick, in their order
  VecX target;                        ///< joint angles that the navigator answered with [rad]
  std::string checksum;               ///< of its whole answer
};

/// What a recorded run was of, each as its option takes it.
struct RecordingHead {
  std::string robot;
  std::string world;
  std::string duration;
  std::string gait;
  std::string on_limit;
  std::string state;
  std::string drive;
};

class RecordingReader {
 public:
  /// @throws InputError the file cannot be read or is not a recording
  explicit RecordingReader(const std::filesystem::path& file);

  [[nodiscard]] const RecordingHead& head() const { return head_; }

  /// The next tick; none at the end. A last line that was cut off is left out.
  /// @param joints that the robot has
  /// @throws InputError a line is not a tick of a recording of such a robot, or there is none at all
  [[nodiscard]] std::optional<RecordedTick> next(Eigen::Index joints);

  /// File and line, as messages begin.
  [[nodiscard]] std::string place() const;

 private:
  /// The next line. @returns whether there was one
  bool read_line(std::string& line);

  std::filesystem::path file_;
  std::ifstream in_;
  RecordingHead head_;
  Command command_;
  long line_ = 0;
  bool whole_ = true;  ///< the last line had an end
};

}  // namespace baton
