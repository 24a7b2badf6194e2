/// Atomic file output: the old file stays until the new one is complete.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace baton {

/// The path a file is written to: symbolic links resolved, even if the target does not exist.
[[nodiscard]] std::filesystem::path link_target(const std::filesystem::path& file);

/// A file written in one go. A regular or new file is written to a temporary file beside it and renamed, so that
/// readers see either the old or the new content; devices and pipes are written directly.
class OutputFile {
 public:
  /// Checks that the file can be written, without changing it.
  /// @param what prefix of every message: the option that names the file
  /// @throws InputError the file cannot be written
  OutputFile(std::filesystem::path file, std::string what);
  /// Leaves the old file in place if `write` was not called.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Writes the whole content. Call once.
  /// @throws std::runtime_error the file was not written completely
  void write(std::string_view text);

 private:
  std::filesystem::path file_;
  std::string what_;
  std::filesystem::path target_;
  std::filesystem::path fresh_;  ///< temporary file; empty: direct output
  int fd_ = -1;
};

/// Opens and writes a file in one call.
/// @throws InputError, std::runtime_error as above
void write_whole(const std::filesystem::path& file, const std::string& what, std::string_view text);

/// Opens and truncates a file, as a descriptor that does not block.
/// @throws InputError the file cannot be opened, or is a pipe without a reader
[[nodiscard]] int open_descriptor(const std::filesystem::path& file, const std::string& what);

/// That a file was not written completely, and why.
/// @param error as in errno; 0: unknown
[[nodiscard]] std::string not_whole(const std::filesystem::path& file, const std::string& what, int error);

/// Opens a file for incremental output.
/// @throws InputError the file cannot be opened, or is a pipe without a reader
[[nodiscard]] std::ofstream open_stream(const std::filesystem::path& file, const std::string& what);

/// @throws std::runtime_error the file was not written completely
void close_stream(std::ofstream& stream, const std::filesystem::path& file, const std::string& what);

}  // namespace baton
