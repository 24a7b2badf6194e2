#include <fmt/format.h>

#include <bit>
#include <limits>
#include <utility>

#include "baton/input/arm_targets_json.hpp"
#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"
#include "baton/record/recording.hpp"

namespace baton {
namespace {

/// What every tick has.
constexpr std::array kNeeded{Topic::joint_states, Topic::imu,           Topic::sole_left,
                             Topic::sole_right,   Topic::joint_targets, Topic::tick};

Command command_in(const JsonReader& read) {
  Command c;
  const std::string guide = read.at("guide").one_of({"left_foot", "right_foot", "left_hand", "right_hand", "trunk"});
  for (const Part part : kParts) {
    if (to_string(part) == guide) c.guide = part;
  }
  c.axes = read.at("axes").vector(6);
  const VecX lift = read.at("lift").vector(2);
  c.lift = {lift[0], lift[1]};
  const std::string recall = read.at("recall").one_of({"none", "retrace", "home", "stop"});
  for (std::size_t i = 0; i < kRecalls.size(); ++i) {
    if (kRecalls[i] == recall) c.recall = static_cast<Recall>(i);
  }
  return c;
}

/// `null` stands for what is not a finite number.
RootMeasurement root_in(const JsonReader& read) {
  RootMeasurement root;
  root.pose.p = read.at("position").vector(3, true);
  root.pose.R = Eigen::Map<const Mat3>(read.at("attitude").vector(9, true).data());
  root.velocity = read.at("velocity").vector(3, true);
  root.rate = read.at("rate").vector(3, true);
  return root;
}

/// The matrix whose bits are so much more than those of another.
Mat3 with_bits_added(Mat3 R, const std::vector<std::int64_t>& more) {
  for (std::size_t i = 0; i < more.size(); ++i) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(R.data()[i]) + static_cast<std::uint64_t>(more[i]);
    R.data()[i] = std::bit_cast<double>(bits);
  }
  return R;
}

/// A setting of the run, as a JSON text for the validating reader.
const std::string& setting(const mcap::Metadata& metadata, const char* key, const std::string& place) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) throw InputError(fmt::format("{}: {} is missing", place, key));
  return found->second;
}

}  // namespace

RecordingReader::RecordingReader(const std::filesystem::path& file) : file_(file, "recording") {
  read_head();
  ahead_ = next_message();
  if (!ahead_) throw InputError(fmt::format("recording {}: holds no ticks", file.string()));
}

std::string RecordingReader::place() const {
  return tick_ < 0 ? file_.place() : fmt::format("{}: tick {}", file_.place(), tick_);
}

void RecordingReader::read_head() {
  const std::string place = file_.place() + ": metadata";
  const auto found = file_.metadata().find("baton");
  if (found == file_.metadata().end())
    throw InputError(fmt::format("{}: has none of a recording by baton drive --record", place));
  const mcap::Metadata& metadata = found->second;
  const auto one_of = [&](const char* key, std::initializer_list<std::string_view> words) {
    const nlohmann::json json{{key, setting(metadata, key, place)}};
    return JsonReader(json, place).at(key).one_of(words);
  };
  if (setting(metadata, "recording", place) != std::to_string(kRecordingVersion)) {
    throw InputError(fmt::format("{}: recording = {}: must be {}, the version that this program reads", place,
                                 shortened(setting(metadata, "recording", place), 40), kRecordingVersion));
  }
  static_cast<void>(one_of("on", {"sim", "ideal", "real"}));
  head_ = {setting(metadata, "robot", place),
           setting(metadata, "world", place),
           one_of("duration", {"paper", "search"}),
           one_of("gait", {"stop", "flow"}),
           one_of("on_limit", {"discard", "shrink"}),
           one_of("state", {"sensors", "torques", "perfect"}),
           one_of("drive", {"torque", "pd", "stiff"}),
           metadata.contains("hangs") && one_of("hangs", {"false", "true"}) == "true",
           {}};
  if (!metadata.contains("start")) return;
  const nlohmann::json start = parse_json(setting(metadata, "start", place), place + ": start");
  for (const JsonReader& value : JsonReader(start, place, "start").list())
    head_.start.push_back(value.number());
}

std::optional<std::pair<Topic, mcap::Message>> RecordingReader::next_message() {
  while (const std::optional<mcap::Message> message = file_.next()) {
    auto known = topics_.find(message->channel);
    if (known == topics_.end()) {
      const mcap::Channel& channel = file_.channels().at(message->channel);
      const auto schema = file_.schemas().find(channel.schema);
      const std::optional<Topic> topic = topic_of(channel, schema != file_.schemas().end() ? &schema->second : nullptr);
      if (!topic || *topic > Topic::events) continue;
      known = topics_.emplace(message->channel, *topic).first;
    }
    return std::pair(known->second, *message);
  }
  return std::nullopt;
}

std::optional<RecordedTick> RecordingReader::next(std::span<const std::string> joints) {
  if (!ahead_) return std::nullopt;
  joints_ = joints;
  RecordedTick tick;
  const std::uint32_t sequence = ahead_->second.sequence;
  tick.number = tick_ = sequence;
  seen_.fill(false);
  attitude_.clear();
  for (; ahead_ && ahead_->second.sequence == sequence; ahead_ = next_message()) {
    const auto& [topic, message] = *ahead_;
    seen_[static_cast<std::size_t>(topic)] = true;
    try {
      take(tick, topic, message.data);
    } catch (const mcap::Malformed& why) {
      throw InputError(fmt::format("{}: {}: {}", place(), info(topic).topic, why.what()));
    }
  }
  const auto must_have = [this](Topic topic) {
    if (!seen_[static_cast<std::size_t>(topic)])
      throw InputError(fmt::format("{}: {} is missing", place(), info(topic).topic));
  };
  for (const Topic topic : kNeeded)
    must_have(topic);
  if (head_.state == "perfect") must_have(Topic::root);
  if (!command_) must_have(Topic::command);
  tick.measurement.imu.attitude = with_bits_added(tick.measurement.imu.attitude, attitude_);
  tick.command = *command_;
  return tick;
}

void RecordingReader::take(RecordedTick& tick, Topic topic, std::string_view message) {
  switch (topic) {
    case Topic::joint_states:
    case Topic::joint_targets:
      take_joints(tick, topic, message);
      return;
    case Topic::imu: {
      ros::Imu imu;
      decode(message, imu);
      tick.measurement.imu = {ros::rotation(imu.orientation), imu.angular_velocity, imu.linear_acceleration};
      return;
    }
    case Topic::sole_left:
    case Topic::sole_right: {
      ros::WrenchStamped sole;
      decode(message, sole);
      tick.measurement.sole[topic == Topic::sole_left ? Side::left : Side::right] = sole.wrench;
      return;
    }
    default:
      break;
  }
  const std::string place = fmt::format("{}: {}", this->place(), info(topic).topic);
  const nlohmann::json json = parse_json(message, place);
  const JsonReader read(json, place);
  if (topic == Topic::tick) take_tick(tick, json, place);
  if (topic == Topic::command) command_ = command_in(read);
  if (topic == Topic::arms) tick.arms.push_back(arm_targets_in(read));
  if (topic == Topic::root) tick.measurement.root = root_in(read);
  if (topic == Topic::events) tick.events.push_back(json);
  if (topic == Topic::planner) {
    const bool asks = read.at("call").one_of({"ask", "offer"}) == "ask";
    tick.calls.push_back(asks ? PlanningEvent::ask : PlanningEvent::answer);
  }
}

void RecordingReader::take_joints(RecordedTick& tick, Topic topic, std::string_view message) {
  ros::JointState state;
  decode(message, state);
  const auto has = [&](const char* what, Eigen::Index size, bool may_be_empty) {
    if (size == std::ssize(joints_) || (may_be_empty && size == 0)) return;
    throw mcap::Malformed(fmt::format("{} has {} members: must be a list of {}", what, size, joints_.size()));
  };
  has("name", std::ssize(state.name), false);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (state.name[i] == joints_[i]) continue;
    throw mcap::Malformed(fmt::format("name[{}] = {}: must be {}, as in the robot's model", i,
                                      shown(nlohmann::json(state.name[i])), joints_[i]));
  }
  has("position", state.position.size(), false);
  if (topic == Topic::joint_targets) {
    tick.target = std::move(state.position);
    return;
  }
  has("velocity", state.velocity.size(), false);
  has("effort", state.effort.size(), true);  // empty: not measured
  tick.measurement.t = 1e-9 * static_cast<double>(state.header.stamp);
  tick.measurement.q = std::move(state.position);
  tick.measurement.dq = std::move(state.velocity);
  tick.measurement.torque = std::move(state.effort);
}

void RecordingReader::take_tick(RecordedTick& tick, const nlohmann::json& message, const std::string& place) {
  const JsonReader read(message, place);
  tick.measurement.age =
      read.at("age").json().is_null() ? std::numeric_limits<double>::quiet_NaN() : read.at("age").number();
  tick.checksum = read.at("sum").text();
  if (!read.has("attitude")) return;
  for (const JsonReader& bits : read.at("attitude").list(9))
    attitude_.push_back(bits.integer(std::numeric_limits<long>::min(), std::numeric_limits<long>::max()));
}

}  // namespace baton
