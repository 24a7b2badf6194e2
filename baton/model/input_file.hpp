/// Files that are read whole: regular ones of a sensible size, so that none blocks the program or fills the memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

namespace baton {

inline constexpr std::uintmax_t kLargestInput = 64U << 20U;  ///< [bytes]

/// @param what the file is, for messages: "script", "profile", …
/// @throws InputError there is no such file, or it is a folder, a device, a pipe, or larger than `largest`
void check_input(const std::filesystem::path& file, const std::string& what, std::uintmax_t largest = kLargestInput);

/// The bytes of a file.
/// @throws InputError as above, or it cannot be read
[[nodiscard]] std::string read_input(const std::filesystem::path& file, const std::string& what);

/// The same of a file or a pipe: a pipe is read to its end, unless `stop` becomes true before.
/// @throws InputError as above
/// @throws std::runtime_error stopped
[[nodiscard]] std::string read_input(const std::filesystem::path& file, const std::string& what,
                                     const std::atomic<bool>& stop);

}  // namespace baton
