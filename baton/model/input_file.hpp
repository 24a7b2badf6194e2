/// Reading whole files. Only regular files of limited size are accepted: others may block, or fill the memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

namespace baton {

inline constexpr std::uintmax_t kLargestInput = 64U << 20U;  ///< [bytes]

/// Checks that a file can be read whole.
/// @param what kind of file, for messages: "script", "profile", …
/// @throws InputError no such file; or it is a folder, a device, a pipe, or larger than `largest` [bytes]
void check_input(const std::filesystem::path& file, const std::string& what, std::uintmax_t largest = kLargestInput);

/// Contents of a file.
/// @throws InputError as above, or not readable
[[nodiscard]] std::string read_input(const std::filesystem::path& file, const std::string& what);

/// Contents of a file or a pipe. A pipe is read to its end, or until `stop` becomes true.
/// @throws InputError as above
/// @throws std::runtime_error stopped
[[nodiscard]] std::string read_input(const std::filesystem::path& file, const std::string& what,
                                     const std::atomic<bool>& stop);

}  // namespace baton
