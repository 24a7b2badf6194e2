/// Files that are written whole: until the new text is complete, the old one stays.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace baton {

/// Where a file is written: symbolic links followed to their end, whether there is something or not.
[[nodiscard]] std::filesystem::path link_target(const std::filesystem::path& file);

/// A file to be written at one go. A regular file, or one that does not exist yet, is written beside and renamed, so
/// that whoever reads it finds the old or the new text; a device or a pipe is written to.
class OutputFile {
 public:
  /// Makes sure that it can be written; what is there stays as it is.
  /// @param what begins every message: the option that names the file
  /// @throws InputError it cannot be
  OutputFile(std::filesystem::path file, std::string what);
  /// Leaves the old file in place if `write` was not called.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// The whole of it. To be called once.
  /// @throws std::runtime_error it could not be written whole
  void write(std::string_view text);

 private:
  std::filesystem::path file_;
  std::string what_;
  std::filesystem::path target_;
  std::filesystem::path fresh_;  ///< beside the target; empty: it is written to directly
  int fd_ = -1;
};

/// Both at once.
/// @throws InputError, std::runtime_error as above
void write_whole(const std::filesystem::path& file, const std::string& what, std::string_view text);

/// A file to be written little by little.
/// @throws InputError it cannot be opened, or is a pipe that nobody reads
[[nodiscard]] std::ofstream open_stream(const std::filesystem::path& file, const std::string& what);

/// @throws std::runtime_error it could not be written whole
void close_stream(std::ofstream& stream, const std::filesystem::path& file, const std::string& what);

}  // namespace baton
