/// Messages that are compressed and written together.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "baton/mcap/bytes.hpp"
#include "baton/mcap/format.hpp"

namespace baton::mcap {

class Chunk {
 public:
  struct Entry {
    std::uint16_t channel = 0;
    std::uint64_t time = 0;    ///< [ns]
    std::uint64_t offset = 0;  ///< of the message's record in `records`
  };

  /// Memory for so much is taken at once; it grows beyond when it has to, and is kept.
  Chunk(std::size_t bytes, std::size_t messages) {
    records_.reserve(bytes);
    entries_.reserve(messages);
  }

  /// @param time when it was recorded [ns]
  void add(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time, std::string_view message) {
    entries_.push_back({channel, time, records_.size()});
    put<std::uint8_t>(records_, static_cast<std::uint8_t>(Op::message));
    put<std::uint64_t>(records_, 2 + 4 + 8 + 8 + message.size());
    put<std::uint16_t>(records_, channel);
    put<std::uint32_t>(records_, sequence);
    put<std::uint64_t>(records_, time);
    put<std::uint64_t>(records_, time);  // published at the same time
    records_.append(message);
  }
  void clear() {
    records_.clear();
    entries_.clear();
  }

  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] const std::string& records() const { return records_; }
  /// In the order in which they were added, which is that of their times.
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::string records_;
  std::vector<Entry> entries_;
};

}  // namespace baton::mcap
