/// What the fuzz targets share. A target takes any bytes as its format: it reads them or throws InputError; anything
/// else (another exception, a sanitizer's report, a failed `require`, a time-out) is a finding.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

namespace baton::fuzz {

/// Ends the run if a property does not hold.
inline void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", property);
  std::abort();
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A file in memory, for readers that take a file: one a process.
inline const std::filesystem::path& file_of(std::string_view text) {
  static const int fd = memfd_create("input", MFD_CLOEXEC);
  static const std::filesystem::path file = "/proc/self/fd/" + std::to_string(fd);
  const bool written = ftruncate(fd, 0) == 0 && pwrite(fd, text.data(), text.size(), 0) == ssize_t(text.size());
  require(written, "the input can be put into memory");
  return file;
}

}  // namespace baton::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
