#include "baton/mcap/writer.hpp"

#include <zstd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace baton::mcap {
namespace {

constexpr int kLevel =
    6;  ///< of the compression; higher ones gain nothing on numbers, up to 15, which takes ten times as long

void put_record(std::string& out, Op op, std::string_view content) {
  put<std::uint8_t>(out, static_cast<std::uint8_t>(op));
  put<std::uint64_t>(out, content.size());
  out.append(content);
}

/// The end of a file without summary.
std::string end_without_summary(std::uint32_t crc) {
  std::string end, content;
  put<std::uint32_t>(content, crc);
  put_record(end, Op::data_end, content);
  put_record(end, Op::footer, std::string(8 + 8 + 4, '\0'));
  return end.append(kMagic);
}

}  // namespace

struct Writer::Compressor {
  ZSTD_CCtx* context = ZSTD_createCCtx();

  Compressor() = default;
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;
  ~Compressor() { ZSTD_freeCCtx(context); }
};

Writer::Writer(std::unique_ptr<Output> output, std::string_view profile, std::string_view library)
    : output_(std::move(output)), compressor_(std::make_unique<Compressor>()), pending_(kMagic) {
  std::string content;
  put_text(content, profile);
  put_text(content, library);
  put_record(pending_, Op::header, content);
}

Writer::~Writer() = default;
Writer::Writer(Writer&&) noexcept = default;

std::uint16_t Writer::add(const Schema& schema) {
  std::string content;
  put<std::uint16_t>(content, ++counts_.schemas);
  put_text(content, schema.name);
  put_text(content, schema.encoding);
  put_text(content, schema.text);
  put_record(pending_, Op::schema, content);
  put_record(schemas_, Op::schema, content);
  return counts_.schemas;
}

std::uint16_t Writer::add(const Channel& channel) {
  counts_.of_channel.push_back(0);
  const auto number = static_cast<std::uint16_t>(counts_.of_channel.size());
  std::string content;
  put<std::uint16_t>(content, number);
  put<std::uint16_t>(content, channel.schema);
  put_text(content, channel.topic);
  put_text(content, channel.encoding);
  put<std::uint32_t>(content, 0);  // metadata: none
  put_record(pending_, Op::channel, content);
  put_record(channels_, Op::channel, content);
  return number;
}

void Writer::add(const std::string& name, const Metadata& metadata) {
  std::string content, map;
  for (const auto& [key, value] : metadata) {
    put_text(map, key);
    put_text(map, value);
  }
  put_text(content, name);
  put_text(content, map);
  std::string index;
  put<std::uint64_t>(index, here());
  put<std::uint64_t>(index, kRecordHead + content.size());
  put_text(index, name);
  put_record(metadata_indexes_, Op::metadata_index, index);
  put_record(pending_, Op::metadata, content);
  ++counts_.metadata;
}

void Writer::add(const Attachment& attachment) {
  std::string content;
  put<std::uint64_t>(content, 0);  // times: those of the run, which begins at 0
  put<std::uint64_t>(content, 0);
  put_text(content, attachment.name);
  put_text(content, attachment.media_type);
  put<std::uint64_t>(content, attachment.data.size());
  content.append(attachment.data);
  put<std::uint32_t>(content, crc32(content));
  std::string index;
  put<std::uint64_t>(index, here());
  put<std::uint64_t>(index, kRecordHead + content.size());
  put<std::uint64_t>(index, 0);
  put<std::uint64_t>(index, 0);
  put<std::uint64_t>(index, attachment.data.size());
  put_text(index, attachment.name);
  put_text(index, attachment.media_type);
  put_record(attachment_indexes_, Op::attachment_index, index);
  put_record(pending_, Op::attachment, content);
  ++counts_.attachments;
}

void Writer::send(std::string_view end) {
  output_->write(pending_, end);
  offset_ += pending_.size();
  pending_.clear();
}

void Writer::flush() {
  crc_ = crc32(pending_, crc_);
  send(end_without_summary(crc_));
}

void Writer::write(const Chunk& chunk) {
  const std::string& records = chunk.records();
  compressed_.resize(ZSTD_compressBound(records.size()));
  const std::size_t size = ZSTD_compressCCtx(compressor_->context, compressed_.data(), compressed_.size(),
                                             records.data(), records.size(), kLevel);
  if (ZSTD_isError(size) != 0U) throw std::runtime_error(ZSTD_getErrorName(size));
  compressed_.resize(size);

  const std::uint64_t begin = chunk.entries().front().time;
  const std::uint64_t end = chunk.entries().back().time;
  const std::uint64_t start = here();
  put<std::uint8_t>(pending_, static_cast<std::uint8_t>(Op::chunk));
  put<std::uint64_t>(pending_, 8 + 8 + 8 + 4 + (4 + 4) + 8 + compressed_.size());
  put<std::uint64_t>(pending_, begin);
  put<std::uint64_t>(pending_, end);
  put<std::uint64_t>(pending_, records.size());
  put<std::uint32_t>(pending_, crc32(records));
  put_text(pending_, "zstd");
  put<std::uint64_t>(pending_, compressed_.size());
  pending_.append(compressed_);
  const std::uint64_t length = here() - start;

  std::string offsets;  // where the index of each channel is
  for (std::size_t i = 0; i < counts_.of_channel.size(); ++i) {
    const auto channel = static_cast<std::uint16_t>(i + 1);
    index_.clear();
    for (const Chunk::Entry& entry : chunk.entries()) {
      if (entry.channel != channel) continue;
      put<std::uint64_t>(index_, entry.time);
      put<std::uint64_t>(index_, entry.offset);
    }
    if (index_.empty()) continue;
    counts_.of_channel[i] += index_.size() / 16;
    put<std::uint16_t>(offsets, channel);
    put<std::uint64_t>(offsets, here());
    put<std::uint8_t>(pending_, static_cast<std::uint8_t>(Op::message_index));
    put<std::uint64_t>(pending_, 2 + 4 + index_.size());
    put<std::uint16_t>(pending_, channel);
    put_text(pending_, index_);
  }

  std::string content;
  put<std::uint64_t>(content, begin);
  put<std::uint64_t>(content, end);
  put<std::uint64_t>(content, start);
  put<std::uint64_t>(content, length);
  put_text(content, offsets);
  put<std::uint64_t>(content, here() - start - length);
  put_text(content, "zstd");
  put<std::uint64_t>(content, compressed_.size());
  put<std::uint64_t>(content, records.size());
  put_record(chunk_indexes_, Op::chunk_index, content);

  if (counts_.messages == 0) counts_.begin = begin;
  counts_.end = std::max(counts_.end, end);
  counts_.messages += chunk.entries().size();
  ++counts_.chunks;
  flush();
}

std::string Writer::statistics() const {
  std::string content, channels;
  put<std::uint64_t>(content, counts_.messages);
  put<std::uint16_t>(content, counts_.schemas);
  put<std::uint32_t>(content, static_cast<std::uint32_t>(counts_.of_channel.size()));
  put<std::uint32_t>(content, counts_.attachments);
  put<std::uint32_t>(content, counts_.metadata);
  put<std::uint32_t>(content, counts_.chunks);
  put<std::uint64_t>(content, counts_.begin);
  put<std::uint64_t>(content, counts_.end);
  for (std::size_t i = 0; i < counts_.of_channel.size(); ++i) {
    put<std::uint16_t>(channels, static_cast<std::uint16_t>(i + 1));
    put<std::uint64_t>(channels, counts_.of_channel[i]);
  }
  put_text(content, channels);
  std::string record;
  put_record(record, Op::statistics, content);
  return record;
}

void Writer::finish() {
  crc_ = crc32(pending_, crc_);
  std::string content;
  put<std::uint32_t>(content, crc_);
  put_record(pending_, Op::data_end, content);
  const std::uint64_t summary = here();
  std::string all, offsets;
  for (const auto& [op, records] : {std::pair<Op, std::string>{Op::schema, schemas_},
                                    {Op::channel, channels_},
                                    {Op::statistics, statistics()},
                                    {Op::chunk_index, chunk_indexes_},
                                    {Op::attachment_index, attachment_indexes_},
                                    {Op::metadata_index, metadata_indexes_}}) {
    if (records.empty()) continue;
    content.clear();
    put<std::uint8_t>(content, static_cast<std::uint8_t>(op));
    put<std::uint64_t>(content, summary + all.size());
    put<std::uint64_t>(content, records.size());
    put_record(offsets, Op::summary_offset, content);
    all += records;
  }
  const std::uint64_t summary_offsets = summary + all.size();
  all += offsets;
  put<std::uint8_t>(all, static_cast<std::uint8_t>(Op::footer));
  put<std::uint64_t>(all, kFooter - kRecordHead);
  put<std::uint64_t>(all, summary);
  put<std::uint64_t>(all, summary_offsets);
  put<std::uint32_t>(all, crc32(all));
  pending_ += all;
  pending_ += kMagic;
  send("");
}

}  // namespace baton::mcap
