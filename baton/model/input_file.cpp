#include "baton/model/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr int kLook = 50;  ///< how often `stop` is looked at [ms]

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what, const std::string& why) {
  throw InputError(fmt::format("{} {}: {}", what, file.string(), why));
}

void check(const std::filesystem::path& file, const std::string& what, std::uintmax_t largest, bool or_pipe) {
  struct stat found {};
  if (stat(file.c_str(), &found) != 0) {
    const bool absent = errno == ENOENT || errno == ENOTDIR;
    refuse(file, what, absent ? "no such file" : fmt::format("cannot be read: {}", std::strerror(errno)));
  }
  if (or_pipe && S_ISFIFO(found.st_mode)) return;
  if (!S_ISREG(found.st_mode)) {
    const char* kind = S_ISDIR(found.st_mode) ? "a folder" : S_ISFIFO(found.st_mode) ? "a pipe" : "a device";
    refuse(file, what, fmt::format("is {}, not a file that can be read whole", kind));
  }
  if (static_cast<std::uintmax_t>(found.st_size) > largest) {
    refuse(file, what, fmt::format("has {} MiB: must be at most {}", found.st_size >> 20, largest >> 20U));
  }
}

std::string read_all(const std::filesystem::path& file, const std::string& what, const std::atomic<bool>* stop) {
  check(file, what, kLargestInput, stop != nullptr);
  // Without waiting: a pipe that nobody writes to would block, whatever signal comes.
  const int fd = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) refuse(file, what, fmt::format("cannot be read: {}", std::strerror(errno)));
  const struct Close {
    int fd;
    ~Close() { close(fd); }
  } closed{fd};
  std::string text;
  std::array<char, 1U << 16U> piece{};
  for (;;) {
    if (stop != nullptr) {
      if (*stop) throw std::runtime_error(fmt::format("{} {}: interrupted while it was read", what, file.string()));
      pollfd ready{fd, POLLIN, 0};
      if (poll(&ready, 1, kLook) <= 0) continue;
    }
    const ssize_t n = read(fd, piece.data(), piece.size());
    if (n == 0) return text;
    if (n < 0 && errno != EAGAIN && errno != EINTR) {
      refuse(file, what, fmt::format("cannot be read: {}", std::strerror(errno)));
    }
    if (n > 0) text.append(piece.data(), static_cast<std::size_t>(n));
    if (text.size() > kLargestInput) {
      refuse(file, what, fmt::format("has more than {} MiB: must be at most that", kLargestInput >> 20U));
    }
  }
}

}  // namespace

void check_input(const std::filesystem::path& file, const std::string& what, std::uintmax_t largest) {
  check(file, what, largest, false);
}

std::string read_input(const std::filesystem::path& file, const std::string& what) {
  return read_all(file, what, nullptr);
}

std::string read_input(const std::filesystem::path& file, const std::string& what, const std::atomic<bool>& stop) {
  return read_all(file, what, &stop);
}

}  // namespace baton
