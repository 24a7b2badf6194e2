/// Recordings of runs (docs/recording.md), in MCAP: all inputs of the navigator, tick by tick, with its joint targets,
/// so that a replay must reproduce the run bit for bit; and what happened, for people and their viewers.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "baton/mcap/reader.hpp"
#include "baton/mcap/writer_thread.hpp"
#include "baton/record/recording_channels.hpp"
#include "baton/record/ros_messages.hpp"
#include "baton/robot/plant.hpp"
#include "baton/run/sink.hpp"

namespace baton {

/// Time for which a chunk is filled [ns]: most of what a kill costs.
inline constexpr std::uint64_t kChunkTime = 80'000'000;

/// Checksum over all bits of a joint target.
[[nodiscard]] std::string checksum(const JointTarget& target);

/// FNV-1a, 64 bits, in hexadecimal: tells whether something is the same, not whether somebody has tampered with it.
[[nodiscard]] std::string checksum(std::string_view bytes);

/// A target's angle as it is recorded: rounded to 2⁻²⁰, 1e-6 [rad]. The checksum has all of its bits.
[[nodiscard]] double recorded_angle(double angle);

/// The whole of a run is written on a thread of its own, a chunk for each 80 ms. In real time the run never waits: when
/// the disk does not keep up with 10 s of it, ticks are left out. When something cannot be written, the recording
/// ends, and the run goes on.
class RecordingWriter : public Sink {
 public:
  struct Parameters {
    bool live = true;  ///< in real time: nothing waits for the disk, and all is synced to it. Else the run may wait.
    std::vector<Push> pushes{};  ///< that the robot will get
    std::vector<mcap::Attachment> attachments{};
    /// Called at most once, on any thread, with why the recording is not complete.
    std::function<void(const std::string&)> warn{};
  };

  /// `robot` must outlive this object.
  /// @param head the run's settings; what is no text is written as JSON
  /// @throws InputError the file cannot be opened
  RecordingWriter(const RobotModel& robot, const std::filesystem::path& file, const nlohmann::json& head,
                  Parameters parameters);
  /// Writes there instead.
  /// @param name of it, for warnings
  RecordingWriter(const RobotModel& robot, std::string name, std::unique_ptr<mcap::Output> output,
                  const nlohmann::json& head, Parameters parameters);

  /// Finishes the file, if `close` was not called.
  ~RecordingWriter() override { close(); }
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  void on_tick(const TickRecord& record) override;
  void on_plan(const PlanRecord& record) override;
  void on_planning(PlanningEvent event) override;
  void on_arms(const ArmTargets& targets) override;

  /// Something that happened outside the navigator, between the ends of a connection; in the next tick, or, at the end,
  /// in the last one.
  /// @param what one of the words of the channel's schema
  void note(const std::string& what, const std::string& text);

  /// Writes all that is left, and finishes the file.
  /// @returns why the recording is not complete; "": it is
  std::string close();

 private:
  [[nodiscard]] mcap::WriterThread::Parameters thread_parameters();
  void warn(const std::string& why);
  /// Gets a chunk for the messages of a tick. @returns whether there is one
  bool begin(std::uint64_t time);
  void add(Topic topic);
  void add(Topic topic, const nlohmann::json& message);
  void add_measurement(const Measurement& measurement);
  void add_tick(const TickRecord& record);
  void add_command(const Command& command);
  void add_events(const TickRecord& record);
  void add_pushes(double t);
  void add_notes();
  void add_estimates(const TickRecord& record);

  std::string name_;  ///< option and file, for warnings
  Parameters parameters_;
  std::atomic<bool> warned_{false};
  mcap::WriterThread thread_;
  mcap::Chunk* chunk_ = nullptr;  ///< being filled; null: ticks are left out
  std::uint64_t begun_ = 0;       ///< time of its first tick [ns]
  std::uint64_t time_ = 0;        ///< of the tick [ns]
  std::uint32_t sequence_ = 0;    ///< number of the tick
  long left_out_ = 0;             ///< ticks
  long each_ = 1;                 ///< ticks from estimates to estimates
  std::string body_;              ///< of the message
  ros::JointState measured_, target_;
  ros::Imu imu_;
  ros::WrenchStamped sole_;
  ros::Transform root_;
  std::optional<Command> command_;  ///< the last one that was recorded
  std::optional<nlohmann::json> offer_;
  std::vector<nlohmann::json> arms_;   ///< for the next tick
  std::vector<nlohmann::json> notes_;  ///< the same
  bool fallen_ = false;
  bool perfect_ = false;  ///< the state is taken from the measured root
};

/// One tick of a recording.
struct RecordedTick {
  long number = 0;  ///< from 0
  Measurement measurement;
  Command command;
  std::vector<ArmTargets> arms;        ///< before the tick, in order
  std::vector<PlanningEvent> calls;    ///< after the tick, in order
  std::vector<nlohmann::json> events;  ///< of the navigator, as `event_messages` gives them
  VecX target;                         ///< joint angles commanded by the navigator (`recorded_angle`) [rad]
  std::string checksum;                ///< of the whole joint target
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
  bool hangs = false;         ///< in a gantry, at its beginning
  std::vector<double> start;  ///< configuration (nq) in which the run began; empty: the stance, at the world's start
};

class RecordingReader {
 public:
  /// @throws InputError the file cannot be read, is not a recording, or holds no ticks
  explicit RecordingReader(const std::filesystem::path& file);

  [[nodiscard]] const RecordingHead& head() const { return head_; }
  [[nodiscard]] const mcap::Reader& file() const { return file_; }

  /// The next tick; none at the end.
  /// @param joints names of the robot's joints
  /// @throws InputError it is none of such a robot, or the file is damaged
  [[nodiscard]] std::optional<RecordedTick> next(std::span<const std::string> joints);

  /// File and place in it, as a prefix for messages.
  [[nodiscard]] std::string place() const;

 private:
  /// The next message of a topic that a replay needs, with the topic.
  [[nodiscard]] std::optional<std::pair<Topic, mcap::Message>> next_message();
  void read_head();
  void take(RecordedTick& tick, Topic topic, std::string_view message);
  void take_joints(RecordedTick& tick, Topic topic, std::string_view message);
  void take_tick(RecordedTick& tick, const nlohmann::json& message, const std::string& place);

  mcap::Reader file_;
  std::map<std::uint16_t, Topic> topics_;
  RecordingHead head_;
  std::optional<std::pair<Topic, mcap::Message>> ahead_;  ///< first message of the next tick
  std::span<const std::string> joints_;
  std::optional<Command> command_;
  std::array<bool, kTopics.size()> seen_{};  ///< topics that the tick has
  std::vector<std::int64_t> attitude_;       ///< correction of the attitude's bits
  long tick_ = -1;
};

}  // namespace baton
