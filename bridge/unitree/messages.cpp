#include "bridge/unitree/messages.hpp"

#include <cstring>

namespace baton::unitree {
namespace {

/// What a byte does to the checksum.
constexpr std::array<std::uint32_t, 256> kOfByte = [] {
  std::array<std::uint32_t, 256> all{};
  for (std::uint32_t byte = 0; byte < all.size(); ++byte) {
    std::uint32_t crc = byte << 24U;
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc << 1U) ^ ((crc >> 31U) != 0 ? 0x04c11db7U : 0U);
    all[byte] = crc;
  }
  return all;
}();

}  // namespace

std::uint32_t crc_of(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (; bytes.size() >= sizeof(std::uint32_t); bytes = bytes.subspan(sizeof(std::uint32_t))) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data(), sizeof(word));
    crc ^= word;  // as its bytes are taken from the highest one on, they can be added at once
    for (int byte = 0; byte < 4; ++byte)
      crc = (crc << 8U) ^ kOfByte[crc >> 24U];
  }
  return crc;
}

}  // namespace baton::unitree
