/// Reads MCAP files from the front, also such as were not finished, as by the end of the process. Chunks may be
/// compressed with zstd or not at all.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include "baton/mcap/bytes.hpp"
#include "baton/mcap/format.hpp"

namespace baton::mcap {

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;  ///< [ns]
  std::string_view data;       ///< until the next message
};

class Reader {
 public:
  /// Reads what comes before the first message.
  /// @param what kind of file, for messages of errors
  /// @throws InputError the file cannot be read, is no MCAP file, or ends before the first message would come
  Reader(const std::filesystem::path& file, std::string what);

  /// The next message, with a channel that is known. None at the end; also in an unfinished file, at the first record
  /// that is not whole.
  /// @throws InputError the file was finished but is damaged here, or has a compression that is unknown here
  [[nodiscard]] std::optional<Message> next();

  [[nodiscard]] const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  [[nodiscard]] const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  [[nodiscard]] const std::map<std::string, Metadata>& metadata() const { return metadata_; }
  [[nodiscard]] const std::map<std::string, Attachment>& attachments() const { return attachments_; }
  [[nodiscard]] const std::string& profile() const { return profile_; }
  [[nodiscard]] const std::string& library() const { return library_; }

  /// Whether the file has its summary and its end.
  [[nodiscard]] bool finished() const { return finished_; }
  /// Bytes at the end of an unfinished file that are not whole records. Known at the end.
  [[nodiscard]] std::uint64_t left() const { return left_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }  ///< of the file [bytes]
  /// What is read, and where, as a prefix for messages.
  [[nodiscard]] std::string place() const;

 private:
  /// Reads the next record of the file into `record_`. @returns its kind; none at the end
  /// @throws Malformed
  std::optional<Op> read_record();
  /// Takes in what the record says. @returns whether there may be messages now
  bool take(Op op);
  void open_chunk();
  /// The next message among those that were read. @throws Malformed
  std::optional<Message> next_in_chunk();
  std::optional<Message> message(std::string_view content);
  void take_channel(std::string_view content);
  void take_schema(std::string_view content);
  /// Ends reading an unfinished file here. @throws InputError it is a finished one
  void give_up(const Malformed& why);

  std::filesystem::path file_;
  std::string what_;
  std::ifstream in_;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;     ///< where the next record begins
  std::uint64_t start_ = 0;  ///< where the last one does
  std::uint64_t left_ = 0;
  bool finished_ = false;
  bool ended_ = false;
  std::string record_;  ///< content of the last record
  std::string chunk_;   ///< records of the last chunk
  std::size_t in_chunk_ = 0;
  std::string profile_, library_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::map<std::string, Metadata> metadata_;
  std::map<std::string, Attachment> attachments_;
};

}  // namespace baton::mcap
