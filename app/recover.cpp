#include <fmt/format.h>

#include <map>
#include <memory>
#include <utility>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/outputs.hpp"
#include "baton/mcap/reader.hpp"
#include "baton/mcap/writer.hpp"
#include "baton/record/recording.hpp"
#include "baton/record/recording_file.hpp"

namespace baton::app {
namespace {

/// Writes what is read of a file into another one.
class Copy {
 public:
  Copy(mcap::Reader& from, const std::filesystem::path& to)
      : from_(&from), writer_(std::make_unique<RecordingFile>(to, "--out"), from.profile(), from.library()) {
    for (const auto& [name, metadata] : from.metadata())
      writer_.add(name, metadata);
    for (const auto& [name, attachment] : from.attachments())
      writer_.add(attachment);
  }

  /// @returns number of messages
  long run() {
    long messages = 0;
    for (; const std::optional<mcap::Message> message = from_->next(); ++messages) {
      if (!chunk_.empty() && message->log_time - chunk_.entries().front().time >= kChunkTime) write();
      chunk_.add(channel(message->channel), message->sequence, message->log_time, message->data);
    }
    if (!chunk_.empty()) write();
    writer_.finish();
    return messages;
  }

 private:
  void write() {
    writer_.write(chunk_);
    chunk_.clear();
  }
  /// The number that a channel has in the new file.
  std::uint16_t channel(std::uint16_t number) {
    const auto found = channels_.find(number);
    if (found != channels_.end()) return found->second;
    mcap::Channel channel = from_->channels().at(number);
    if (const auto schema = from_->schemas().find(channel.schema); schema != from_->schemas().end()) {
      std::uint16_t& copied = schemas_[channel.schema];
      if (copied == 0) copied = writer_.add(schema->second);
      channel.schema = copied;
    } else {
      channel.schema = 0;
    }
    return channels_[number] = writer_.add(channel);
  }

  mcap::Reader* from_;
  mcap::Writer writer_;
  mcap::Chunk chunk_{0, 0};
  std::map<std::uint16_t, std::uint16_t> channels_, schemas_;  ///< old → new number
};

}  // namespace

int recover(const RecoverOptions& o) {
  check_distinct({{"--out", o.out}}, {{"RECORDING", o.recording}});
  mcap::Reader reader(o.recording, "recording");
  const bool finished = reader.finished();
  const long messages = Copy(reader, o.out).run();
  fmt::print("{}: {} messages{}\n", o.out.string(), messages,
             finished ? "; the recording was finished already"
                      : fmt::format("; {} bytes at the recording's end were no whole chunk", reader.left()));
  return kDone;
}

}  // namespace baton::app
