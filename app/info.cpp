#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "baton/input/json_reader.hpp"
#include "baton/mcap/reader.hpp"
#include "baton/model/error.hpp"
#include "baton/record/recording_channels.hpp"

namespace baton::app {
namespace {

constexpr std::size_t kMostShown = 10;  ///< events, or gaps

/// What a recording has, message by message.
class Summary {
 public:
  explicit Summary(mcap::Reader& reader) : reader_(&reader) {
    while (const std::optional<mcap::Message> message = reader.next())
      add(*message);
  }

  [[nodiscard]] double seconds() const { return 1e-9 * static_cast<double>(last_ - first_) + period(); }

  void print() const {
    fmt::print("length    {:.1f} s, {} ticks; {:.2f} MB, {:.1f} kB/s\n", seconds(), ticks_,
               1e-6 * static_cast<double>(reader_->size()),
               seconds() > 0.0 ? 1e-3 * static_cast<double>(reader_->size()) / seconds() : 0.0);
    if (reader_->finished()) {
      fmt::print("end       finished\n");
    } else {
      fmt::print("end       not finished; {} bytes at its end are no whole chunk\n", reader_->left());
    }
    print_list("gaps", gaps_);
    fmt::print("\n{:<18} {:>9} {:>9}  {}\n", "channel", "messages", "per s", "schema");
    for (const auto& [number, count] : counts_) {
      const mcap::Channel& channel = reader_->channels().at(number);
      const auto schema = reader_->schemas().find(channel.schema);
      fmt::print("{:<18} {:>9} {:>9.1f}  {}\n", channel.topic, count,
                 seconds() > 0.0 ? static_cast<double>(count) / seconds() : 0.0,
                 schema != reader_->schemas().end() ? schema->second.name : "");
    }
    std::string counts;
    for (const auto& [event, count] : events_)
      counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, event);
    fmt::print("\nevents    {}\n", counts.empty() ? "none" : counts);
    for (std::size_t i = 0; i < std::min(shown_.size(), kMostShown); ++i)
      fmt::print("  {}\n", shown_[i]);
    if (shown_.size() > kMostShown) fmt::print("  and {} more\n", shown_.size() - kMostShown);
  }

 private:
  [[nodiscard]] double period() const {
    return last_tick_ > first_tick_ ? 1e-9 * static_cast<double>(last_ - first_) / (last_tick_ - first_tick_) : 0.0;
  }

  static void print_list(const char* what, const std::vector<std::string>& list) {
    std::string text;
    for (std::size_t i = 0; i < std::min(list.size(), kMostShown); ++i)
      text += (i == 0 ? "" : ", ") + list[i];
    if (list.size() > kMostShown) text += fmt::format(", and {} more", list.size() - kMostShown);
    fmt::print("{:<9} {}\n", what, text.empty() ? "none" : text);
  }

  void add(const mcap::Message& message) {
    ++counts_[message.channel];
    const mcap::Channel& channel = reader_->channels().at(message.channel);
    if (channel.topic == info(Topic::tick).topic) add_tick(message);
    for (const Topic topic : {Topic::events, Topic::pushes, Topic::falls, Topic::link}) {
      if (channel.topic == info(topic).topic) add_event(topic, message);
    }
  }

  void add_tick(const mcap::Message& message) {
    if (ticks_++ == 0) {
      first_ = message.log_time;
      first_tick_ = message.sequence;
    } else if (message.sequence != last_tick_ + 1) {
      gaps_.push_back(fmt::format("ticks {} to {} ({:.2f} s)", last_tick_ + 1, message.sequence - 1U,
                                  1e-9 * static_cast<double>(message.log_time - last_)));
    }
    last_ = message.log_time;
    last_tick_ = message.sequence;
  }

  static std::string event_in(const nlohmann::json& json, const char* key) {
    if (!json.is_object()) return "event";
    const auto named = json.find(key);
    return named != json.end() && named->is_string() ? named->get<std::string>() : "event";
  }

  /// Counts an event; shows those that are not of every step.
  void add_event(Topic topic, const mcap::Message& message) {
    const nlohmann::json json = parse_json(message.data, reader_->place());
    const std::string name = topic == Topic::pushes  ? "push"
                             : topic == Topic::falls ? "fall"
                             : topic == Topic::link  ? "link: " + event_in(json, "what")
                                                     : event_in(json, "event");
    ++events_[name];
    if (name == "committed" || name == "ended") return;
    std::string details;
    for (const auto& [key, value] : json.items()) {
      if (key != "event" && key != "what")
        details += fmt::format(" {} {}", key, value.is_string() ? value.get<std::string>() : value.dump());
    }
    shown_.push_back(
        fmt::format("{:9.2f} s  {}{}", 1e-9 * static_cast<double>(message.log_time), name, shortened(details, 90)));
  }

  mcap::Reader* reader_;
  std::map<std::uint16_t, long> counts_;  ///< by channel
  std::map<std::string, long> events_;
  std::vector<std::string> shown_, gaps_;
  long ticks_ = 0;
  std::uint64_t first_ = 0, last_ = 0;            ///< [ns]
  std::uint32_t first_tick_ = 0, last_tick_ = 0;  ///< numbers
};

}  // namespace

int show_info(const InfoOptions& o) {
  mcap::Reader reader(o.recording, "recording");
  const auto found = reader.metadata().find("baton");
  if (found == reader.metadata().end())
    throw InputError(fmt::format("{}: is no recording by baton drive --record", reader.place()));
  const mcap::Metadata& head = found->second;
  const auto value = [&](const char* key) {
    const auto it = head.find(key);
    return it == head.end() ? std::string("?") : shortened(it->second, 60);
  };
  fmt::print("recording {}\n", o.recording.string());
  fmt::print("run       {} on {} in {}, seed {}\n", value("robot"), value("on"), value("world"), value("seed"));
  fmt::print("modes     duration {}, gait {}, on limit {}, state {}, drive {}\n", value("duration"), value("gait"),
             value("on_limit"), value("state"), value("drive"));
  if (head.contains("plant"))
    fmt::print("plant     {}{}\n", value("plant"),
               head.contains("scenario") ? fmt::format(", scenario {} x {}", value("scenario"), value("times")) : "");
  fmt::print("made by   baton {}, MuJoCo {}; sums: model {}, world {}, profile {}\n", value("baton"), value("mujoco"),
             value("model_sum"), value("world_sum"), value("profile_sum"));
  Summary(reader).print();
  return kDone;
}

}  // namespace baton::app
