/// What an MCAP file consists of (https://mcap.dev/spec).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace baton::mcap {

/// Begins and ends a file.
inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};

/// Each record is its kind (8 bits), the length of its content (64 bits), and the content.
enum class Op : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

inline constexpr std::size_t kRecordHead = 9;                    ///< kind and length of a record [bytes]
inline constexpr std::size_t kFooter = kRecordHead + 8 + 8 + 4;  ///< [bytes]

/// What the messages of channels are made of.
struct Schema {
  std::string name;      ///< "sensor_msgs/msg/Imu"
  std::string encoding;  ///< of the text: ros2msg or jsonschema
  std::string text;
};

struct Channel {
  std::uint16_t schema = 0;  ///< 0: none
  std::string topic;
  std::string encoding;  ///< of its messages: cdr or json
};

/// Text that comes with the file, for programs.
using Metadata = std::map<std::string, std::string>;

/// A file inside the file.
struct Attachment {
  std::string name;
  std::string media_type;
  std::string data;
};

/// CRC-32 (IEEE 802.3) of more bytes.
/// @param before of the bytes before them; 0: none
[[nodiscard]] std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace baton::mcap
