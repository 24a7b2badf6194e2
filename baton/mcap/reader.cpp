#include "baton/mcap/reader.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <limits>
#include <utility>

#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"

namespace baton::mcap {
namespace {

constexpr std::uint64_t kLargest = 64U << 20U;  ///< content of a record, or of a chunk uncompressed [bytes]
constexpr std::size_t kMostNamed = 1000;        ///< schemas, channels, metadata or attachments

/// Whether the file ends with a footer that has a summary.
bool has_summary(std::ifstream& in, std::uint64_t size) {
  std::string end(kFooter + kMagic.size(), '\0');
  if (size < end.size()) return false;
  in.seekg(static_cast<std::streamoff>(size - end.size()));
  in.read(end.data(), static_cast<std::streamsize>(end.size()));
  if (!in || !end.ends_with(kMagic)) return false;
  Cursor cursor(end);
  const bool footer = static_cast<Op>(cursor.number<std::uint8_t>()) == Op::footer &&
                      cursor.number<std::uint64_t>() == kFooter - kRecordHead;
  return footer && cursor.number<std::uint64_t>() != 0;
}

/// Numbers that are not ours are kept out of a map that would grow without bound.
template <typename Map>
void check_count(const Map& map) {
  if (map.size() >= kMostNamed) throw Malformed(fmt::format("has more than {} of a kind", kMostNamed));
}

}  // namespace

Reader::Reader(const std::filesystem::path& file, std::string what) : file_(file), what_(std::move(what)) {
  check_input(file, what_, std::numeric_limits<std::uintmax_t>::max());
  std::error_code error;
  size_ = std::filesystem::file_size(file, error);
  in_.open(file, std::ios::binary);
  if (error || !in_) throw InputError(fmt::format("{} {}: cannot be read", what_, file.string()));
  std::string magic(kMagic.size(), '\0');
  in_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (!in_ || magic != kMagic) {
    throw InputError(fmt::format("{} {}: is not an MCAP file{}", what_, file.string(),
                                 magic[0] == '{' ? "; recordings in JSON Lines are of an older version of baton" : ""));
  }
  finished_ = has_summary(in_, size_);
  in_.clear();
  in_.seekg(static_cast<std::streamoff>(kMagic.size()));
  at_ = kMagic.size();
  try {
    if (read_record() != Op::header) throw Malformed("has no header");
    Cursor header(record_);
    profile_ = header.text();
    library_ = header.text();
    for (std::optional<Op> op; (op = read_record());) {
      if (take(*op)) return;
    }
  } catch (const Malformed& why) {
    give_up(why);
  }
  throw InputError(fmt::format("{} {}: ends before its first message", what_, file.string()));
}

std::string Reader::place() const {
  return fmt::format("{} {}: byte {}", what_, file_.string(), start_);
}

void Reader::give_up(const Malformed& why) {
  if (finished_) throw InputError(fmt::format("{}: {}", place(), why.what()));
  left_ = size_ - start_;
  ended_ = true;
}

std::optional<Op> Reader::read_record() {
  start_ = at_;
  if (ended_ || at_ == size_) return std::nullopt;
  if (size_ - at_ < kRecordHead) throw Malformed("ends in the middle of a record");
  std::string head(kRecordHead, '\0');
  in_.read(head.data(), static_cast<std::streamsize>(head.size()));
  Cursor cursor(head);
  const auto op = static_cast<Op>(cursor.number<std::uint8_t>());
  const auto length = cursor.number<std::uint64_t>();
  if (!in_ || length > size_ - at_ - kRecordHead) throw Malformed("ends in the middle of a record");
  if (op == Op{} || length > kLargest) throw Malformed("is not a record");
  record_.resize(length);
  in_.read(record_.data(), static_cast<std::streamsize>(length));
  if (!in_) throw Malformed("cannot be read");
  at_ += kRecordHead + length;
  if (op == Op::data_end) ended_ = true;
  return op;
}

bool Reader::take(Op op) {
  Cursor cursor(record_);
  switch (op) {
    case Op::schema:
      take_schema(record_);
      return false;
    case Op::channel:
      take_channel(record_);
      return false;
    case Op::metadata: {
      check_count(metadata_);
      Metadata& map = metadata_[std::string(cursor.text())];
      Cursor entries(cursor.text());
      while (!entries.done()) {
        const std::string_view key = entries.text();
        map[std::string(key)] = entries.text();
      }
      return false;
    }
    case Op::attachment: {
      check_count(attachments_);
      static_cast<void>(cursor.take(16));  // times
      Attachment attachment;
      attachment.name = cursor.text();
      attachment.media_type = cursor.text();
      attachment.data = cursor.take(cursor.number<std::uint64_t>());
      const std::uint32_t crc = crc32(std::string_view(record_).substr(0, cursor.at()));
      const auto stated = cursor.number<std::uint32_t>();
      if (stated != 0 && stated != crc) throw Malformed("has an attachment with a wrong checksum");
      attachments_[attachment.name] = std::move(attachment);
      return false;
    }
    case Op::chunk:
      open_chunk();
      return true;
    case Op::message:  // outside of a chunk
      chunk_.clear();
      put<std::uint8_t>(chunk_, static_cast<std::uint8_t>(op));
      put<std::uint64_t>(chunk_, record_.size());
      chunk_ += record_;
      in_chunk_ = 0;
      return true;
    default:
      return false;
  }
}

void Reader::open_chunk() {
  Cursor cursor(record_);
  static_cast<void>(cursor.take(16));  // times of its messages
  const auto size = cursor.number<std::uint64_t>();
  const auto crc = cursor.number<std::uint32_t>();
  const std::string_view compression = cursor.text();
  const std::string_view records = cursor.take(cursor.number<std::uint64_t>());
  if (size > kLargest) throw Malformed("has a chunk that is too large");
  if (compression == "zstd") {
    chunk_.resize(size);
    const std::size_t got = ZSTD_decompress(chunk_.data(), chunk_.size(), records.data(), records.size());
    if (ZSTD_isError(got) != 0U || got != size) throw Malformed("has a chunk that cannot be decompressed");
  } else if (compression.empty()) {
    chunk_ = records;
  } else {
    throw InputError(fmt::format("{}: has a chunk that is compressed by '{}': must be zstd, or not compressed", place(),
                                 std::string(compression.substr(0, 20))));
  }
  if (crc != 0 && crc != crc32(chunk_)) throw Malformed("has a chunk with a wrong checksum");
  in_chunk_ = 0;
}

void Reader::take_schema(std::string_view content) {
  check_count(schemas_);
  Cursor cursor(content);
  const auto number = cursor.number<std::uint16_t>();
  Schema schema;
  schema.name = cursor.text();
  schema.encoding = cursor.text();
  schema.text = cursor.text();
  schemas_.insert_or_assign(number, std::move(schema));
}

void Reader::take_channel(std::string_view content) {
  check_count(channels_);
  Cursor cursor(content);
  const auto number = cursor.number<std::uint16_t>();
  Channel channel;
  channel.schema = cursor.number<std::uint16_t>();
  channel.topic = cursor.text();
  channel.encoding = cursor.text();
  channels_.insert_or_assign(number, std::move(channel));
}

std::optional<Message> Reader::message(std::string_view content) {
  Cursor cursor(content);
  Message message;
  message.channel = cursor.number<std::uint16_t>();
  message.sequence = cursor.number<std::uint32_t>();
  message.log_time = cursor.number<std::uint64_t>();
  static_cast<void>(cursor.number<std::uint64_t>());  // when it was published
  if (!channels_.contains(message.channel)) throw Malformed(fmt::format("has no channel {}", message.channel));
  message.data = cursor.take(content.size() - cursor.at());
  return message;
}

std::optional<Message> Reader::next_in_chunk() {
  while (in_chunk_ < chunk_.size()) {
    Cursor cursor(std::string_view(chunk_).substr(in_chunk_));
    const auto op = static_cast<Op>(cursor.number<std::uint8_t>());
    const std::string_view content = cursor.take(cursor.number<std::uint64_t>());
    in_chunk_ += cursor.at();
    if (op == Op::schema) take_schema(content);
    if (op == Op::channel) take_channel(content);
    if (op == Op::message) return message(content);
  }
  return std::nullopt;
}

std::optional<Message> Reader::next() {
  try {
    for (;;) {
      if (std::optional<Message> message = next_in_chunk()) return message;
      const std::optional<Op> op = read_record();
      if (!op) return std::nullopt;
      take(*op);
    }
  } catch (const Malformed& why) {
    chunk_.clear();
    in_chunk_ = 0;
    give_up(why);
  }
  return std::nullopt;
}

}  // namespace baton::mcap
