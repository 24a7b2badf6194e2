/// Writes MCAP files: chunks compressed with zstd, each with its message index; at the end statistics and an index of
/// the chunks. After every chunk the file is a valid one, if it can be written to at any place: it ends with a footer,
/// which the next chunk replaces.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "baton/mcap/chunk.hpp"
#include "baton/mcap/format.hpp"

namespace baton::mcap {

/// Port: where the bytes go.
class Output {
 public:
  virtual ~Output() = default;

  /// Appends bytes, and an end that the next call replaces. An output that cannot go back leaves out the end.
  /// @throws std::runtime_error not all of it was written; what was written before is still there
  virtual void write(std::string_view bytes, std::string_view end) = 0;

  /// Has what was written survive a power cut, as far as the system can.
  virtual void sync() {}
};

class Writer {
 public:
  /// @param profile what a reader may expect of the messages: ros2, or "" for nothing
  /// @param library who writes it
  Writer(std::unique_ptr<Output> output, std::string_view profile, std::string_view library);
  ~Writer();
  Writer(Writer&&) noexcept;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  Writer& operator=(Writer&&) = delete;

  // What follows is written together with the first chunk, or by `flush`.

  /// @returns number of the schema
  std::uint16_t add(const Schema& schema);
  /// @returns number of the channel
  std::uint16_t add(const Channel& channel);
  void add(const std::string& name, const Metadata& metadata);
  void add(const Attachment& attachment);

  /// @throws std::runtime_error not all of it was written. Nothing can be written after that.
  void flush();
  /// Compresses and writes a chunk, which must not be empty.
  /// @throws std::runtime_error as above
  void write(const Chunk& chunk);
  /// Writes the summary. Nothing can be written after that.
  /// @throws std::runtime_error as above
  void finish();
  /// `Output::sync`
  void sync() { output_->sync(); }

 private:
  struct Compressor;

  /// Where in the file the next byte of `pending_` will be.
  [[nodiscard]] std::uint64_t here() const { return offset_ + pending_.size(); }
  /// Writes what is pending.
  void send(std::string_view end);
  [[nodiscard]] std::string statistics() const;

  std::unique_ptr<Output> output_;
  std::unique_ptr<Compressor> compressor_;
  std::uint64_t offset_ = 0;  ///< bytes written
  std::uint32_t crc_ = 0;     ///< of them
  std::string pending_;       ///< to be written next
  std::string compressed_;
  std::string index_;  ///< message indexes of a chunk
  /// Records of the summary, by kind.
  std::string schemas_, channels_, chunk_indexes_, attachment_indexes_, metadata_indexes_;
  struct Counts {
    std::uint16_t schemas = 0;
    std::uint32_t attachments = 0;
    std::uint32_t metadata = 0;
    std::uint32_t chunks = 0;
    std::uint64_t messages = 0;
    std::uint64_t begin = 0;  ///< time of the first message [ns]
    std::uint64_t end = 0;
    std::vector<std::uint64_t> of_channel;  ///< from number 1 on
  } counts_;
};

}  // namespace baton::mcap
