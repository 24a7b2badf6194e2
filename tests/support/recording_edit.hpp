/// A recording taken apart, to be changed and put together again.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "baton/mcap/reader.hpp"
#include "baton/mcap/writer.hpp"
#include "baton/record/recording_file.hpp"

namespace baton::test {

/// The bytes that are written, as a string.
class Memory : public mcap::Output {
 public:
  explicit Memory(std::string& bytes) : bytes_(&bytes) {}
  void write(std::string_view bytes, std::string_view end) override {
    bytes_->resize(size_);
    bytes_->append(bytes).append(end);
    size_ += bytes.size();
  }

 private:
  std::string* bytes_;
  std::size_t size_ = 0;
};

struct RecordingParts {
  struct Part {
    std::string topic;
    std::uint32_t sequence = 0;
    std::uint64_t time = 0;
    std::string data;

    [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(data); }
  };

  mcap::Metadata metadata;
  std::vector<mcap::Schema> schemas;
  std::vector<mcap::Channel> channels;
  std::vector<Part> messages;

  explicit RecordingParts(const std::filesystem::path& file) {
    mcap::Reader reader(file, "recording");
    metadata = reader.metadata().at("baton");
    for (const auto& [number, schema] : reader.schemas())
      schemas.push_back(schema);
    for (const auto& [number, channel] : reader.channels())
      channels.push_back(channel);
    while (const auto message = reader.next()) {
      messages.push_back({reader.channels().at(message->channel).topic, message->sequence, message->log_time,
                          std::string(message->data)});
    }
  }

  /// The first message of a topic, of a tick.
  [[nodiscard]] Part& at(const std::string& topic, std::uint32_t sequence) {
    for (Part& part : messages) {
      if (part.topic == topic && part.sequence == sequence) return part;
    }
    throw std::out_of_range(topic);
  }
  [[nodiscard]] long count(const std::string& topic) const {
    long count = 0;
    for (const Part& part : messages)
      count += part.topic == topic ? 1 : 0;
    return count;
  }

  /// The file that they make.
  /// @param per_chunk ticks of a chunk
  [[nodiscard]] std::string bytes(bool finished = true, std::uint32_t per_chunk = 20) const {
    std::string bytes;
    mcap::Writer writer(std::make_unique<Memory>(bytes), "ros2", "test");
    writer.add("baton", metadata);
    for (const mcap::Schema& schema : schemas)
      writer.add(schema);
    std::map<std::string, std::uint16_t> numbers;
    for (const mcap::Channel& channel : channels)
      numbers[channel.topic] = writer.add(channel);
    mcap::Chunk chunk(0, 0);
    std::uint32_t begin = 0;
    const auto write = [&] {
      if (!chunk.empty()) writer.write(chunk);
      chunk.clear();
    };
    for (const Part& part : messages) {
      if (part.sequence >= begin + per_chunk) {
        write();
        begin = part.sequence;
      }
      chunk.add(numbers.at(part.topic), part.sequence, part.time, part.data);
    }
    write();
    if (finished) writer.finish();
    return bytes;
  }
};

}  // namespace baton::test
